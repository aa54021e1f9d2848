#include "core/simulation/random.h"

#include <cmath>

#include "core/geometry/angles.h"

namespace arborslam {
namespace {

constexpr uint64_t kGoldenGamma = 0x9e3779b97f4a7c15ULL;

uint64_t Mix(uint64_t z) {
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  return z ^ (z >> 31);
}

}  // namespace

// Two rounds of mixing, or neighbouring streams would be the same sequence shifted.
Random::Random(uint64_t seed, uint64_t stream) : state_(Mix(Mix(seed + kGoldenGamma) ^ (stream * kGoldenGamma))) {}

uint64_t Random::Bits() {
  state_ += kGoldenGamma;
  return Mix(state_);
}

double Random::Uniform() { return static_cast<double>(Bits() >> 11) * 0x1.0p-53; }

double Random::Gaussian() {
  const double radius = std::sqrt(2.0 * Exponential());
  return radius * std::cos(2.0 * kPi * Uniform());
}

double Random::Exponential() { return -std::log1p(-Uniform()); }

}  // namespace arborslam
