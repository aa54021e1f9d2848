#ifndef ARBORSLAM_CORE_CONFIG_VALIDATION_H_
#define ARBORSLAM_CORE_CONFIG_VALIDATION_H_

#include <string>

namespace arborslam {

/// `value` in the fewest digits that read back as the same double, in a form that every YAML reader takes for a
/// floating-point number: "0.7", "20.0", "1.0e-05".
std::string FormatDouble(double value);

/// What `Validate()` of an options struct returns for a key out of range: "alpha_min is 1.3, must lie in (0, 1]".
/// The first word is the key, so that `ConfigSchema::ValidateAll` can say where the value came from.
std::string Violation(const std::string& key, double value, const std::string& requirement);
std::string Violation(const std::string& key, int value, const std::string& requirement);
std::string Violation(const std::string& key, const std::string& value, const std::string& requirement);

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_CONFIG_VALIDATION_H_
