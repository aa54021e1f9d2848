#include "core/config/config_schema.h"

#include <glog/logging.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <sstream>
#include <system_error>
#include <type_traits>

#include "core/config/edit_distance.h"
#include "core/config/validation.h"
#include "core/error.h"

namespace arborslam {
namespace {

// No configuration is longer than this; a recording passed by mistake is.
constexpr std::uintmax_t kMaxFileSize = 1 << 20;
// How much of a value or name an error message repeats: messages are one line.
constexpr size_t kMaxQuoted = 60;

bool IsName(const std::string& name) {
  return !name.empty() && std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_';
  });
}

// Also with the capital T of a transform, T_a_b.
bool IsKey(const std::string& key) { return IsName(key.rfind("T_", 0) == 0 ? key.substr(1) : key); }

// `text` without control characters, cut off where it gets too long for a message.
std::string OneLine(const std::string& text) {
  std::string line = text.substr(0, kMaxQuoted);
  std::replace_if(
      line.begin(), line.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; }, '?');
  return line + (text.size() > kMaxQuoted ? "..." : "");
}

std::string Quoted(const std::string& text) { return "'" + OneLine(text) + "'"; }

// The text without a leading '+', which std::from_chars does not take but users and YAML do.
std::string WithoutPlus(const std::string& text) {
  const bool has_plus = text.size() > 1 && text[0] == '+' && text[1] != '-' && text[1] != '+';
  return has_plus ? text.substr(1) : text;
}

template <class Number>
std::errc ParseNumber(const std::string& text, Number* number) {
  const std::string digits = WithoutPlus(text);
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), *number);
  if (end != digits.data() + digits.size() && error != std::errc::invalid_argument) return std::errc::invalid_argument;
  return error;
}

std::string Lowercase(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  return text;
}

bool LooksLikeNotFinite(const std::string& text) {
  std::string word = Lowercase(WithoutPlus(text));
  if (!word.empty() && word[0] == '-') word.erase(0, 1);
  return word == ".inf" || word == ".nan" || word == "inf" || word == "nan" || word == "infinity";
}

// True if a YAML reader takes the plain scalar for something else than a string.
bool LooksTyped(const std::string& text) {
  double number = 0.0;
  constexpr std::array<const char*, 11> kWords = {"", "~", "null", "true", "false", "yes", "no", "on", "off", "y", "n"};
  return ParseNumber(text, &number) != std::errc::invalid_argument || LooksLikeNotFinite(text) ||
         std::find(kWords.begin(), kWords.end(), Lowercase(text)) != kWords.end();
}

std::string StringToYaml(const std::string& text) {
  const auto is_plain = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '/' ||
           c == '.';
  };
  if (std::all_of(text.begin(), text.end(), is_plain) && !LooksTyped(text)) return text;
  std::string quoted = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') {
      quoted += '\\';
      quoted += c;
    } else if (byte < 0x20 || byte == 0x7f) {
      std::array<char, 8> escape;
      std::snprintf(escape.data(), escape.size(), "\\x%02x", byte);
      quoted += escape.data();
    } else {
      quoted += c;
    }
  }
  return quoted + "\"";
}

std::string ReadWholeFile(const std::string& path) {
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(path, error);
  if (!std::filesystem::exists(status)) throw UserError(path, "no such configuration file", "check the path");
  if (std::filesystem::is_directory(status)) {
    throw UserError(path, "is a folder, not a configuration file", "name a YAML file");
  }
  std::ifstream file(path, std::ios::binary);
  std::string text;
  char c = 0;
  // Read by hand up to the limit: the size of a pipe or a device is not known beforehand.
  while (text.size() <= kMaxFileSize && file.get(c)) text += c;
  if (text.size() > kMaxFileSize) {
    throw UserError(path, "is longer than 1 MiB, so it is no configuration file", "name a YAML file");
  }
  if (!file.eof()) throw UserError(path, "cannot be read", "check that you have the right to read it");
  return text;
}

std::string KindOf(const YAML::Node& node) {
  if (node.IsMap()) return "a map";
  if (node.IsSequence()) return "a list";
  if (node.IsNull()) return "nothing";
  return Quoted(node.Scalar());
}

}  // namespace

void ConfigSchema::AddSection(Section section) {
  CHECK(IsName(section.name)) << "section name '" << section.name << "'";
  CHECK(FindSection(section.name) == nullptr) << "section " << section.name << " is bound twice";
  std::vector<std::string> keys;
  for (Field& field : section.fields) {
    CHECK(IsKey(field.key)) << "key '" << field.key << "' of section " << section.name;
    CHECK(std::find(keys.begin(), keys.end(), field.key) == keys.end())
        << "key " << field.key << " of section " << section.name << " is bound twice";
    keys.push_back(field.key);
    field.default_text = ValueToYaml(field.value);
  }
  sections_.push_back(std::move(section));
}

ConfigSchema::Section* ConfigSchema::FindSection(const std::string& name) {
  const auto found = std::find_if(sections_.begin(), sections_.end(), [&](const Section& s) { return s.name == name; });
  return found == sections_.end() ? nullptr : &*found;
}

ConfigSchema::Field* ConfigSchema::FindField(Section* section, const std::string& key) {
  std::vector<Field>& fields = section->fields;
  const auto found = std::find_if(fields.begin(), fields.end(), [&](const Field& f) { return f.key == key; });
  return found == fields.end() ? nullptr : &*found;
}

std::string ConfigSchema::SectionsWithKey(const std::string& key) const {
  std::string names;
  for (const Section& section : sections_) {
    for (const Field& field : section.fields) {
      if (field.key == key) names += (names.empty() ? "" : ", ") + section.name + "." + key;
    }
  }
  return names;
}

std::string ConfigSchema::SectionSuggestion(const std::string& name) const {
  const std::string keys = SectionsWithKey(name);
  if (!keys.empty()) return "it is a key of a section: " + keys;
  std::vector<std::string> names;
  for (const Section& section : sections_) names.push_back(section.name);
  return names.empty() ? "there are no sections" : "did you mean '" + NearestName(name, names) + "'?";
}

std::string ConfigSchema::KeySuggestion(const Section& section, const std::string& key) const {
  const std::string elsewhere = SectionsWithKey(key);
  if (!elsewhere.empty()) return "did you mean " + elsewhere + "?";
  std::vector<std::string> keys;
  for (const Field& field : section.fields) keys.push_back(field.key);
  return keys.empty() ? "the section has no keys" : "did you mean '" + NearestName(key, keys) + "'?";
}

ConfigSchema::Value ConfigSchema::Convert(const std::string& section, const Field& field, const Scalar& scalar,
                                          const std::string& origin) {
  const std::string name = section + "." + field.key;
  const std::string remedy = "its default is " + field.default_text;
  const auto wrong = [&](const std::string& expected) {
    const std::string shown = scalar.plain ? Quoted(scalar.text) : "the string " + Quoted(scalar.text);
    return UserError(origin, name + " is " + shown + ", expected " + expected, remedy);
  };
  return std::visit(
      [&](const auto* target) -> Value {
        using Type = std::remove_const_t<std::remove_pointer_t<decltype(target)>>;
        if constexpr (std::is_same_v<Type, std::string>) {
          if (!scalar.verbatim && scalar.plain && LooksTyped(scalar.text)) throw wrong("a string, in quotes");
          return scalar.text;
        } else if constexpr (std::is_same_v<Type, bool>) {
          if (!scalar.plain || (scalar.text != "true" && scalar.text != "false")) throw wrong("true or false");
          return scalar.text == "true";
        } else {
          const std::string expected = std::is_same_v<Type, int> ? "an integer" : "a finite number";
          Type number{};
          if (!scalar.plain) throw wrong(expected);
          const std::errc error = ParseNumber(scalar.text, &number);
          if (error == std::errc::result_out_of_range) throw wrong(expected + " that the computer can represent");
          // std::from_chars also knows forms such as "nan(1)".
          if (error != std::errc() || !std::isfinite(static_cast<double>(number))) throw wrong(expected);
          return number;
        }
      },
      field.value);
}

void ConfigSchema::Apply(const std::vector<Assignment>& assignments) {
  for (const Assignment& assignment : assignments) {
    std::visit([&](auto* target) { *target = std::get<std::remove_pointer_t<decltype(target)>>(assignment.value); },
               assignment.field->value);
    assignment.field->origin = assignment.origin;
  }
}

void ConfigSchema::LoadYamlFile(const std::string& path) { LoadYaml(ReadWholeFile(path), path); }

void ConfigSchema::LoadYaml(const std::string& text, const std::string& path) {
  const auto at = [&](const YAML::Node& node) { return path + ":" + std::to_string(node.Mark().line + 1); };
  const auto key_name = [&](const YAML::Node& key) {
    if (!key.IsScalar()) throw UserError(at(key), "a key is " + KindOf(key), "write keys as plain words");
    return key.Scalar();
  };

  std::vector<YAML::Node> documents;
  try {
    documents = YAML::LoadAll(text);
  } catch (const YAML::Exception& error) {
    const bool has_line = !error.mark.is_null();
    throw UserError(has_line ? path + ":" + std::to_string(error.mark.line + 1) : path,
                    "is not valid YAML: " + OneLine(error.msg), "correct the syntax");
  }
  if (documents.size() > 1) throw UserError(path, "holds several YAML documents", "leave only one");
  if (documents.empty() || documents[0].IsNull()) return;

  const YAML::Node& root = documents[0];
  if (!root.IsMap()) {
    throw UserError(at(root), "holds " + KindOf(root) + ", expected sections with keys", "write 'section:' lines");
  }
  std::vector<Assignment> assignments;
  std::map<std::string, std::string> seen;
  for (const auto& section_entry : root) {
    const std::string section_name = key_name(section_entry.first);
    const std::string section_place = at(section_entry.first);
    Section* const section = FindSection(section_name);
    if (section == nullptr) {
      throw UserError(section_place, "unknown section " + Quoted(section_name), SectionSuggestion(section_name));
    }
    const auto [first_section, is_new_section] = seen.emplace(section_name, section_place);
    if (!is_new_section) {
      throw UserError(section_place, "duplicate section '" + section_name + "', first at " + first_section->second,
                      "merge the two");
    }
    const YAML::Node& body = section_entry.second;
    if (body.IsNull()) continue;
    if (!body.IsMap()) {
      throw UserError(section_place,
                      "section '" + section_name + "' is " + KindOf(body) + ", expected keys with values",
                      "write 'key: value' lines below it");
    }
    for (const auto& entry : body) {
      const std::string key = key_name(entry.first);
      const std::string place = at(entry.first);
      Field* const field = FindField(section, key);
      if (field == nullptr) {
        throw UserError(place, "unknown key " + Quoted(key) + " in section '" + section_name + "'",
                        KeySuggestion(*section, key));
      }
      const auto [first_key, is_new_key] = seen.emplace(section_name + "." + key, place);
      if (!is_new_key) {
        throw UserError(place, "duplicate key '" + section_name + "." + key + "', first at " + first_key->second,
                        "leave only one");
      }
      const YAML::Node& value = entry.second;
      // Tags: "?" is a plain scalar, "!" a quoted one; all others ask for a type, which the schema decides.
      if (!value.IsScalar() || (value.Tag() != "?" && value.Tag() != "!")) {
        throw UserError(place, section_name + "." + key + " is " + KindOf(value) + ", expected one value without a tag",
                        "its default is " + field->default_text);
      }
      const Scalar scalar{value.Scalar(), value.Tag() == "?", false};
      assignments.push_back({field, Convert(section_name, *field, scalar, place), place});
    }
  }
  Apply(assignments);
}

void ConfigSchema::ApplyOverride(const std::string& assignment) {
  const size_t equals = assignment.find('=');
  const std::string name = assignment.substr(0, equals);
  const std::string origin = "--set " + OneLine(assignment);
  if (equals == std::string::npos) {
    throw UserError(origin, "has no '='", "write it as section.key=value");
  }
  const size_t dot = name.find('.');
  const std::string section_name = name.substr(0, dot);
  if (dot == std::string::npos) {
    const std::string keys = SectionsWithKey(name);
    throw UserError(origin, Quoted(name) + " names no section",
                    keys.empty() ? "write it as section.key=value" : "did you mean " + keys + "?");
  }
  Section* const section = FindSection(section_name);
  if (section == nullptr) {
    throw UserError(origin, "unknown section " + Quoted(section_name), SectionSuggestion(section_name));
  }
  const std::string key = name.substr(dot + 1);
  Field* const field = FindField(section, key);
  if (field == nullptr) {
    throw UserError(origin, "unknown key " + Quoted(key) + " in section '" + section_name + "'",
                    KeySuggestion(*section, key));
  }
  const Scalar scalar{assignment.substr(equals + 1), true, true};
  Apply({{field, Convert(section_name, *field, scalar, origin), origin}});
}

void ConfigSchema::ValidateAll() const {
  for (const Section& section : sections_) {
    const std::string problem = section.validate();
    if (problem.empty()) continue;
    const std::string key = problem.substr(0, problem.find(' '));
    const auto field =
        std::find_if(section.fields.begin(), section.fields.end(), [&](const Field& f) { return f.key == key; });
    CHECK(field != section.fields.end()) << "Validate() of section " << section.name << " names no key: " << problem;
    if (field->origin.empty()) {
      throw UserError(section.name + "." + key, problem + " (it is the default)",
                      "set it to suit the other values of section '" + section.name + "'");
    }
    throw UserError(field->origin, section.name + "." + problem, "its default is " + field->default_text);
  }
}

std::string ConfigSchema::ValueToYaml(const ValuePointer& value) {
  return std::visit(
      [](const auto* target) -> std::string {
        using Type = std::remove_const_t<std::remove_pointer_t<decltype(target)>>;
        if constexpr (std::is_same_v<Type, std::string>) return StringToYaml(*target);
        if constexpr (std::is_same_v<Type, bool>) return *target ? "true" : "false";
        if constexpr (std::is_same_v<Type, int>) return std::to_string(*target);
        if constexpr (std::is_same_v<Type, double>) return FormatDouble(*target);
      },
      value);
}

std::string ConfigSchema::ToYaml() const {
  std::ostringstream yaml;
  for (const Section& section : sections_) {
    yaml << section.name << ":" << (section.fields.empty() ? " {}" : "") << "\n";
    for (const Field& field : section.fields) yaml << "  " << field.key << ": " << ValueToYaml(field.value) << "\n";
  }
  return yaml.str();
}

}  // namespace arborslam
