#ifndef ARBORSLAM_CORE_ERROR_H_
#define ARBORSLAM_CORE_ERROR_H_

#include <stdexcept>
#include <string>

namespace arborslam {

/// An error that the user caused and can mend: a missing file, a damaged record, an option out of range.
/// The programs print `what()` as their one line and exit with a code that is not 0. Scan-level trouble is
/// not an error but a verdict, and programmer errors are `CHECK`s.
class UserError : public std::runtime_error {
 public:
  /// The message reads "place: problem; remedy".
  /// @param place   file (and line, record or key) or flag at fault.
  /// @param problem what is wrong, with the offending value.
  /// @param remedy  what the user can do about it.
  UserError(const std::string& place, const std::string& problem, const std::string& remedy)
      : std::runtime_error(place + ": " + problem + "; " + remedy) {}
};

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_ERROR_H_
