#ifndef ARBORSLAM_CORE_IO_NATURAL_ORDER_H_
#define ARBORSLAM_CORE_IO_NATURAL_ORDER_H_

#include <string_view>

namespace arborslam {

/// True if `a` comes before `b` when runs of digits count by their value, of any length, and all else byte by byte:
/// "scan9" before "scan10" before "scan010" (equal values: the shorter first). A strict total order.
bool NaturallyLess(std::string_view a, std::string_view b);

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_IO_NATURAL_ORDER_H_
