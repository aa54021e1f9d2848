#include "frontend/matching/modified_hausdorff.h"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace arborslam {

std::string MhdOptions::Validate() const {
  std::ostringstream error;
  if (!(alpha_min > 0.0 && alpha_min <= 1.0)) {
    error << "alpha_min is " << alpha_min << ", must lie in (0, 1]";
  } else if (!(alpha_max >= alpha_min && alpha_max <= 1.0)) {
    error << "alpha_max is " << alpha_max << ", must lie in [alpha_min, 1]";
  }
  return error.str();
}

int ChooseK(int num_near, int num_points, const MhdOptions& options) {
  const int least = static_cast<int>(std::ceil(options.alpha_min * num_points - 1e-9));
  const int most = std::max(least, static_cast<int>(std::floor(options.alpha_max * num_points + 1e-9)));
  return std::clamp(num_near, least, most);
}

MhdResult ModifiedHausdorff(std::vector<float>* distances, double max_distance, const MhdOptions& options) {
  MhdResult result;
  if (distances->empty()) {
    result.score = max_distance;
    return result;
  }
  const auto limit = static_cast<float>(max_distance);
  int num_near = 0;
  for (float& distance : *distances) {
    num_near += distance < limit;
    distance = std::min(distance, limit);
  }
  const int num_points = static_cast<int>(distances->size());
  result.num_used = ChooseK(num_near, num_points, options);
  result.inlier_ratio = static_cast<double>(num_near) / num_points;
  const auto kth = distances->begin() + result.num_used - 1;
  std::nth_element(distances->begin(), kth, distances->end());
  result.cutoff = *kth;
  double sum = 0.0;
  for (auto it = distances->begin(); it <= kth; ++it) sum += *it;
  result.score = sum / result.num_used;
  return result;
}

}  // namespace arborslam
