#ifndef ARBORSLAM_CORE_CONFIG_CONFIG_SCHEMA_H_
#define ARBORSLAM_CORE_CONFIG_CONFIG_SCHEMA_H_

#include <functional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace arborslam {

/// The sections and keys that a configuration may hold, each key bound to a field of an options struct.
///
/// An options struct has in-class defaults, a method template `VisitFields(visitor)` that calls
/// `visitor("key", field)` for every field (double, int, bool or std::string) in the order of declaration, and
/// `std::string Validate() const`, which returns "" or what is wrong, beginning with the key (see `Violation`):
///
///     ConfigSchema schema;
///     schema.AddSection("matcher", &options.matcher);
///     schema.LoadYamlFile(FLAGS_config);
///     for (const std::string& assignment : overrides) schema.ApplyOverride(assignment);
///     schema.ValidateAll();
///
/// Reading is strict: unknown sections and keys, duplicates, wrong types and values that are not finite are errors.
/// A call that throws leaves every option as it was. Not thread-safe.
class ConfigSchema {
 public:
  /// Binds section `name` to `*options`, which is borrowed and must outlive the schema. The values held at this moment
  /// are the defaults. Section names must be unique and consist of lower-case letters, digits and underscores; keys
  /// likewise, but for the T of a transform T_a_b.
  template <class Options>
  void AddSection(const std::string& name, Options* options) {
    Section section;
    section.name = name;
    options->VisitFields([&section](const std::string& key, auto& value) {
      Field field;
      field.key = key;
      field.value = &value;
      section.fields.push_back(std::move(field));
    });
    section.validate = [options] { return options->Validate(); };
    AddSection(std::move(section));
  }

  /// Sets the options that the file names; an empty file is a valid one and sets none. Throws `UserError` naming
  /// file and line.
  void LoadYamlFile(const std::string& path);

  /// The same with the text of a file; `path` is what errors name.
  void LoadYaml(const std::string& text, const std::string& path);

  /// Sets one option from "section.key=value". The value of a string option is everything after the first '='.
  /// Throws `UserError`.
  void ApplyOverride(const std::string& assignment);

  /// Calls `Validate()` of every section and throws `UserError` for the first value out of range, naming the file and
  /// line or the override that set it.
  void ValidateAll() const;

  /// The configuration in effect: all sections and keys in the order they were declared, numbers so that reading them
  /// back gives the same bits.
  std::string ToYaml() const;

 private:
  using ValuePointer = std::variant<double*, int*, bool*, std::string*>;
  using Value = std::variant<double, int, bool, std::string>;

  struct Field {
    std::string key;
    ValuePointer value;
    std::string default_text;  // As YAML.
    std::string origin;        // "file:line" or "--set ..." that set the value; empty while it is the default.
  };

  struct Section {
    std::string name;
    std::vector<Field> fields;
    std::function<std::string()> validate;
  };

  struct Assignment {
    Field* field;
    Value value;
    std::string origin;
  };

  // What a piece of text is, as far as it matters for its conversion: `text` is what the user wrote.
  struct Scalar {
    std::string text;
    bool plain = true;     // Not quoted: may be a number or a bool.
    bool verbatim = true;  // From the command line: a string option takes it whatever it looks like.
  };

  void AddSection(Section section);
  Section* FindSection(const std::string& name);
  static Field* FindField(Section* section, const std::string& key);
  std::string SectionSuggestion(const std::string& name) const;
  std::string KeySuggestion(const Section& section, const std::string& key) const;
  // "section.key" of the keys called `key` in any section, comma-separated; empty if there are none.
  std::string SectionsWithKey(const std::string& key) const;
  static Value Convert(const std::string& section, const Field& field, const Scalar& scalar, const std::string& origin);
  static void Apply(const std::vector<Assignment>& assignments);
  static std::string ValueToYaml(const ValuePointer& value);

  std::vector<Section> sections_;
};

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_CONFIG_CONFIG_SCHEMA_H_
