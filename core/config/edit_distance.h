#ifndef ARBORSLAM_CORE_CONFIG_EDIT_DISTANCE_H_
#define ARBORSLAM_CORE_CONFIG_EDIT_DISTANCE_H_

#include <cstddef>
#include <string>
#include <vector>

namespace arborslam {

/// The least number of characters to insert, delete or replace that turns `a` into `b` (Levenshtein 1966).
size_t EditDistance(const std::string& a, const std::string& b);

/// The candidate with the least edit distance to `name`, the first of equals; empty if there are no candidates.
std::string NearestName(const std::string& name, const std::vector<std::string>& candidates);

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_CONFIG_EDIT_DISTANCE_H_
