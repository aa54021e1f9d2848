#ifndef ARBORSLAM_CORE_SIMULATION_RANDOM_H_
#define ARBORSLAM_CORE_SIMULATION_RANDOM_H_

#include <cstdint>

namespace arborslam {

/// Random numbers that are the same on every machine: the distributions of <random> are left to each standard library.
/// The generator is SplitMix64 (Steele, Lea, Flood 2014). A (seed, stream) pair starts a sequence of its own, so that
/// the n-th scan of a run can be drawn without drawing those before it.
class Random {
 public:
  explicit Random(uint64_t seed, uint64_t stream = 0);

  /// 64 independent bits.
  uint64_t Bits();

  /// Uniform in [0, 1), a multiple of 2^-53.
  double Uniform();

  /// Uniform in [low, high).
  double Uniform(double low, double high) { return low + (high - low) * Uniform(); }

  /// Normal with mean 0 and standard deviation 1 (Box and Muller 1958). Always takes two numbers off the sequence.
  double Gaussian();

  /// Exponential with mean 1.
  double Exponential();

 private:
  uint64_t state_;
};

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_SIMULATION_RANDOM_H_
