#include "apps/common/command_line.h"

#include <gflags/gflags.h>

#include <algorithm>

#include "core/config/edit_distance.h"

namespace arborslam {
namespace {

bool IsFlag(const std::string& argument) { return argument.rfind("--", 0) == 0; }

std::string Folder(const std::string& path) { return path.substr(0, path.find_last_of('/') + 1); }

bool Contains(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

std::string Article(const std::string& type) {
  if (type == "bool") return "true or false";
  if (type == "double") return "a number";
  if (type == "string") return "a text";
  return type.rfind("uint", 0) == 0 ? "a whole number that is not negative" : "a whole number";
}

}  // namespace

std::vector<std::string> ExtractMultiFlag(std::vector<std::string>* arguments, const std::string& name) {
  const std::string flag = "--" + name;
  const std::string flag_with_value = flag + "=";
  std::vector<std::string> values;
  std::vector<std::string> others;
  for (size_t i = 0; i < arguments->size();) {
    const std::string& argument = (*arguments)[i];
    const bool has_value = argument.rfind(flag_with_value, 0) == 0;
    if (argument != flag && !has_value) {
      others.push_back(argument);
      ++i;
      continue;
    }
    const size_t num_values = values.size();
    if (argument.size() > flag_with_value.size()) values.push_back(argument.substr(flag_with_value.size()));
    for (++i; i < arguments->size() && !IsFlag((*arguments)[i]); ++i) values.push_back((*arguments)[i]);
    if (values.size() == num_values) throw UsageError(flag + " needs at least one value");
  }
  *arguments = std::move(others);
  return values;
}

void SetFlags(const std::vector<std::string>& arguments, const std::vector<std::string>& known,
              const std::vector<std::string>& also_known) {
  for (size_t i = 0; i < arguments.size(); ++i) {
    const std::string& argument = arguments[i];
    if (!IsFlag(argument)) {
      throw UsageError("argument '" + argument + "' belongs to no flag; see --help");
    }
    const size_t equals = argument.find('=');
    const std::string name = argument.substr(2, equals == std::string::npos ? std::string::npos : equals - 2);
    gflags::CommandLineFlagInfo info;
    if (!Contains(known, name) || !gflags::GetCommandLineFlagInfo(name.c_str(), &info)) {
      if (name.rfind("no", 0) == 0 && Contains(known, name.substr(2)) && equals == std::string::npos &&
          gflags::GetCommandLineFlagInfo(name.c_str() + 2, &info) && info.type == "bool") {
        gflags::SetCommandLineOption(info.name.c_str(), "false");
        continue;
      }
      std::vector<std::string> candidates = known;
      candidates.insert(candidates.end(), also_known.begin(), also_known.end());
      throw UsageError("unknown flag --" + name + "; the nearest is --" + NearestName(name, candidates) +
                       ", all are in --help");
    }
    std::string value;
    if (equals != std::string::npos) {
      value = argument.substr(equals + 1);
    } else if (info.type == "bool") {
      value = "true";
    } else if (i + 1 < arguments.size() && !IsFlag(arguments[i + 1])) {
      value = arguments[++i];
    } else {
      throw UsageError("--" + name + " needs a value");
    }
    if (gflags::SetCommandLineOption(name.c_str(), value.c_str()).empty()) {
      throw UsageError("--" + name + " is '" + value + "' but must be " + Article(info.type));
    }
  }
}

std::vector<std::string> FlagsDefinedBeside(const std::string& source_file) {
  std::vector<gflags::CommandLineFlagInfo> flags;
  gflags::GetAllFlags(&flags);
  std::vector<std::string> names;
  for (const gflags::CommandLineFlagInfo& flag : flags) {
    if (Folder(flag.filename) == Folder(source_file)) names.push_back(flag.name);
  }
  return names;
}

}  // namespace arborslam
