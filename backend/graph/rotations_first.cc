#include "backend/graph/rotations_first.h"

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <complex>

namespace arborslam {
namespace {

using Complex = std::complex<double>;
using Places = std::vector<Eigen::Index>;
constexpr Eigen::Index kHeld = -1;

// The normal equations of a linear least squares problem, of which the lower triangle is filled.
template <class Scalar>
class NormalEquations {
 public:
  using Vector = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;

  explicit NormalEquations(Eigen::Index size) : right_(Vector::Zero(size)) {}

  void Add(Eigen::Index row, Eigen::Index column, const Scalar& value) {
    if (row >= column) entries_.emplace_back(row, column, value);
  }
  Scalar& Right(Eigen::Index row) { return right_(row); }

  std::optional<Vector> Solve() const {
    Eigen::SparseMatrix<Scalar> matrix(right_.size(), right_.size());
    matrix.setFromTriplets(entries_.begin(), entries_.end());
    const Eigen::SimplicialLLT<Eigen::SparseMatrix<Scalar>> cholesky(matrix);
    if (cholesky.info() != Eigen::Success) return std::nullopt;
    Vector solution = cholesky.solve(right_);
    if (!solution.allFinite()) return std::nullopt;
    return solution;
  }

 private:
  std::vector<Eigen::Triplet<Scalar>> entries_;
  Vector right_;
};

// Minimises the sum of w |z_to - exp(i theta_from_to) z_from|^2 over complex numbers z, whose angles are orientations.
bool SolveRotations(const std::vector<RelativePose>& measurements, const Places& place, Eigen::Index size,
                    std::vector<Eigen::Vector3d>* poses) {
  NormalEquations<Complex> equations(size);
  for (const RelativePose& measured : measurements) {
    const double weight = measured.information(2, 2);
    const Complex turn = std::polar(1.0, measured.T_from_to.theta());
    const Eigen::Index from = place[measured.from];
    const Eigen::Index to = place[measured.to];
    if (from != kHeld) equations.Add(from, from, weight);
    if (to != kHeld) equations.Add(to, to, weight);
    if (from != kHeld && to != kHeld) {
      equations.Add(to, from, -weight * turn);
      equations.Add(from, to, -weight * std::conj(turn));
    } else if (from != kHeld) {
      equations.Right(from) += weight * std::conj(turn) * std::polar(1.0, (*poses)[measured.to].z());
    } else if (to != kHeld) {
      equations.Right(to) += weight * turn * std::polar(1.0, (*poses)[measured.from].z());
    }
  }
  const auto solution = equations.Solve();
  if (!solution) return false;
  for (size_t i = 0; i < place.size(); ++i) {
    if (place[i] != kHeld) (*poses)[i].z() = std::arg((*solution)(place[i]));
  }
  return true;
}

// Minimises the weighted errors in position, orientations being what they are.
bool SolvePositions(const std::vector<RelativePose>& measurements, const Places& place, Eigen::Index size,
                    std::vector<Eigen::Vector3d>* poses) {
  NormalEquations<double> equations(2 * size);
  for (const RelativePose& measured : measurements) {
    const double heading = (*poses)[measured.from].z();
    const Eigen::Vector2d step = SE2(0.0, 0.0, heading) * measured.T_from_to.translation();
    const Eigen::Matrix2d R_map_to = SE2(0.0, 0.0, heading + measured.T_from_to.theta()).rotation();
    const Eigen::Matrix2d weight = R_map_to * measured.information.topLeftCorner<2, 2>() * R_map_to.transpose();
    const Eigen::Index from = place[measured.from];
    const Eigen::Index to = place[measured.to];
    Eigen::Vector2d difference = step;
    if (from == kHeld) difference += (*poses)[measured.from].head<2>();
    if (to == kHeld) difference -= (*poses)[measured.to].head<2>();
    const Eigen::Vector2d right = weight * difference;
    for (Eigen::Index row = 0; row < 2; ++row) {
      if (from != kHeld) equations.Right(2 * from + row) -= right(row);
      if (to != kHeld) equations.Right(2 * to + row) += right(row);
      for (Eigen::Index column = 0; column < 2; ++column) {
        const double value = weight(row, column);
        if (from != kHeld) equations.Add(2 * from + row, 2 * from + column, value);
        if (to != kHeld) equations.Add(2 * to + row, 2 * to + column, value);
        if (from == kHeld || to == kHeld) continue;
        equations.Add(2 * from + row, 2 * to + column, -value);
        equations.Add(2 * to + row, 2 * from + column, -value);
      }
    }
  }
  const auto solution = equations.Solve();
  if (!solution) return false;
  for (size_t i = 0; i < place.size(); ++i) {
    if (place[i] != kHeld) (*poses)[i].head<2>() = solution->segment<2>(2 * place[i]);
  }
  return true;
}

}  // namespace

std::optional<std::vector<Eigen::Vector3d>> SolveRotationsFirst(const std::vector<Eigen::Vector3d>& poses,
                                                                const std::vector<RelativePose>& measurements,
                                                                const std::vector<size_t>& held) {
  Places place(poses.size(), 0);
  for (const size_t i : held) place[i] = kHeld;
  Eigen::Index size = 0;
  for (Eigen::Index& index : place) {
    if (index != kHeld) index = size++;
  }
  std::vector<Eigen::Vector3d> solved = poses;
  if (size == 0) return solved;
  if (!SolveRotations(measurements, place, size, &solved)) return std::nullopt;
  if (!SolvePositions(measurements, place, size, &solved)) return std::nullopt;
  return solved;
}

}  // namespace arborslam
