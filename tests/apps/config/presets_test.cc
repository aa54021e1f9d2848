// The shipped configurations against the options of the code.

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>
#include <vector>

#include "apps/offline/offline_options.h"
#include "core/config/config_schema.h"

namespace arborslam {
namespace {

namespace fs = std::filesystem;

const fs::path kFolder = fs::path(ARBORSLAM_SOURCE_DIR) / "config";

std::vector<fs::path> Presets() {
  std::vector<fs::path> presets;
  for (const fs::directory_entry& entry : fs::directory_iterator(kFolder)) {
    if (entry.path().extension() == ".yaml") presets.push_back(entry.path());
  }
  std::sort(presets.begin(), presets.end());
  return presets;
}

void AddSections(OfflineOptions* options, ConfigSchema* schema) {
  options->VisitSections([schema](const std::string& name, auto& section) { schema->AddSection(name, &section); });
}

std::vector<std::string> Lines(const std::string& text) {
  std::istringstream stream(text);
  std::vector<std::string> lines;
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

std::vector<std::string> LinesOfFile(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return Lines({std::istreambuf_iterator<char>(file), {}});
}

// What is left of a line of YAML (without '#' in strings) when its comment and trailing blanks are taken away.
std::string WithoutComment(const std::string& line) {
  const std::string content = line.substr(0, line.find('#'));
  return content.substr(0, content.find_last_not_of(' ') + 1);
}

TEST(PresetsTest, EveryPresetIsValid) {
  const std::vector<fs::path> presets = Presets();
  EXPECT_GE(presets.size(), 2u);
  for (const fs::path& preset : presets) {
    OfflineOptions options;
    ConfigSchema schema;
    AddSections(&options, &schema);
    EXPECT_NO_THROW({
      schema.LoadYamlFile(preset.string());
      schema.ValidateAll();
    }) << preset;
  }
}

TEST(PresetsTest, TheDefaultsAreThoseOfTheCode) {
  OfflineOptions options;
  ConfigSchema schema;
  AddSections(&options, &schema);
  const std::string before = schema.ToYaml();
  schema.LoadYamlFile((kFolder / "default.yaml").string());
  // Line by line, so that a failure tells which value drifted.
  EXPECT_EQ(Lines(schema.ToYaml()), Lines(before));
}

TEST(PresetsTest, TheDefaultsNameEverySectionAndKeyInTheOrderOfTheCode) {
  OfflineOptions options;
  ConfigSchema schema;
  AddSections(&options, &schema);
  const auto names = [](const std::vector<std::string>& lines) {
    std::vector<std::string> result;
    for (const std::string& line : lines) {
      const std::string content = WithoutComment(line);
      if (!content.empty()) result.push_back(content.substr(0, content.find(':')));
    }
    return result;
  };
  EXPECT_EQ(names(LinesOfFile(kFolder / "default.yaml")), names(Lines(schema.ToYaml())));
}

TEST(PresetsTest, EveryLineOfTheDefaultsIsExplained) {
  const std::vector<std::string> lines = LinesOfFile(kFolder / "default.yaml");
  for (size_t i = 0; i < lines.size(); ++i) {
    EXPECT_LE(lines[i].size(), 120u) << lines[i];
    const std::string content = WithoutComment(lines[i]);
    if (content.empty()) continue;
    const bool is_section = content.back() == ':';
    const bool is_explained =
        is_section ? i > 0 && lines[i - 1].rfind("# ", 0) == 0 : lines[i].find("  # ") != std::string::npos;
    EXPECT_TRUE(is_explained) << lines[i];
  }
}

}  // namespace
}  // namespace arborslam
