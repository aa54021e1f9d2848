#ifndef ARBORSLAM_CORE_CONFIG_EDIT_DISTANCE_H_
#define ARBORSLAM_CORE_CONFIG_EDIT_DISTANCE_H_

#include <cstddef>
#include <string>
#include <vector>

namespace arborslam {

/// How many insertions, deletions and replacements of a character, or swaps of two neighbours, turn `a` into `b`
/// (Damerau-Levenshtein, in the variant that edits no place twice).
size_t EditDistance(const std::string& a, const std::string& b);

/// The candidate with the least edit distance to `name`, the first of equals; empty if there are no candidates.
std::string NearestName(const std::string& name, const std::vector<std::string>& candidates);

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_CONFIG_EDIT_DISTANCE_H_
