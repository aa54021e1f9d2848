#include "core/config/config_schema.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <random>

#include "core/config/validation.h"
#include "core/error.h"

namespace arborslam {
namespace {

struct MatcherOptions {
  double alpha_min = 0.7;
  double alpha_max = 0.8;
  int max_iterations = 20;
  bool robust = true;
  std::string model = "unicycle";

  std::string Validate() const {
    if (!(alpha_min > 0.0 && alpha_min <= 1.0)) return Violation("alpha_min", alpha_min, "lie in (0, 1]");
    if (!(alpha_max >= alpha_min)) return Violation("alpha_max", alpha_max, "be at least alpha_min");
    if (max_iterations < 1) return Violation("max_iterations", max_iterations, "be at least 1");
    return "";
  }

  template <class Visitor>
  void VisitFields(Visitor&& visit) {
    visit("alpha_min", alpha_min);
    visit("alpha_max", alpha_max);
    visit("max_iterations", max_iterations);
    visit("robust", robust);
    visit("model", model);
  }
};

struct WindowOptions {
  int size = 15;
  double sigma = 0.05;

  std::string Validate() const { return size < 2 ? Violation("size", size, "be at least 2") : ""; }

  template <class Visitor>
  void VisitFields(Visitor&& visit) {
    visit("size", size);
    visit("sigma", sigma);
  }
};

class ConfigSchemaTest : public testing::Test {
 protected:
  void SetUp() override {
    const auto* info = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = std::filesystem::path(testing::TempDir()) /
              ("config_schema_" + std::string(info->name()) + "_" + std::to_string(getpid()));
    std::filesystem::create_directories(folder_);
    path_ = (folder_ / "test.yaml").string();
    schema_.AddSection("matcher", &matcher_);
    schema_.AddSection("window", &window_);
  }

  void TearDown() override { std::filesystem::remove_all(folder_); }

  void Load(const std::string& text) {
    std::ofstream(path_, std::ios::binary) << text;
    schema_.LoadYamlFile(path_);
  }

  // The message of the UserError that `action` throws, with the file's folder cut away; "" if it throws none.
  template <class Action>
  std::string ErrorOf(Action&& action) {
    try {
      action();
    } catch (const UserError& error) {
      std::string message = error.what();
      EXPECT_EQ(message.find('\n'), std::string::npos) << message;
      for (size_t at = 0; (at = message.find(folder_.string() + "/")) != std::string::npos;) {
        message.erase(at, folder_.string().size() + 1);
      }
      return message;
    }
    return "";
  }
  std::string LoadError(const std::string& text) {
    return ErrorOf([&] { Load(text); });
  }
  std::string OverrideError(const std::string& assignment) {
    return ErrorOf([&] { schema_.ApplyOverride(assignment); });
  }
  std::string ValidationError() {
    return ErrorOf([&] { schema_.ValidateAll(); });
  }

  MatcherOptions matcher_;
  WindowOptions window_;
  ConfigSchema schema_;
  std::filesystem::path folder_;
  std::string path_;
};

constexpr char kDefaultYaml[] =
    "matcher:\n"
    "  alpha_min: 0.7\n"
    "  alpha_max: 0.8\n"
    "  max_iterations: 20\n"
    "  robust: true\n"
    "  model: unicycle\n"
    "window:\n"
    "  size: 15\n"
    "  sigma: 0.05\n";

TEST_F(ConfigSchemaTest, FilesWithoutAnythingKeepTheDefaults) {
  for (const std::string text : {"", "\n\n", "# only a comment\n", "---\n", "{}", "matcher:\n", "matcher: {}\n",
                                 "\xef\xbb\xbf# byte order mark\n"}) {
    Load(text);
    EXPECT_EQ(schema_.ToYaml(), kDefaultYaml) << text;
  }
  EXPECT_EQ(ValidationError(), "");
}

TEST_F(ConfigSchemaTest, SetsEveryTypeAndLeavesTheRest) {
  Load("matcher:\n  alpha_min: 0.5\n  max_iterations: +7\n  robust: false\n  model: omni_2\nwindow: {sigma: 1e-3}\n");
  EXPECT_EQ(matcher_.alpha_min, 0.5);
  EXPECT_EQ(matcher_.alpha_max, 0.8);
  EXPECT_EQ(matcher_.max_iterations, 7);
  EXPECT_FALSE(matcher_.robust);
  EXPECT_EQ(matcher_.model, "omni_2");
  EXPECT_EQ(window_.size, 15);
  EXPECT_EQ(window_.sigma, 1e-3);
}

TEST_F(ConfigSchemaTest, LaterSourcesWin) {
  Load("window:\n  size: 3\n  sigma: 1\n");
  Load("window:\n  size: 4\n");
  EXPECT_EQ(window_.size, 4);
  EXPECT_EQ(window_.sigma, 1.0);
  schema_.ApplyOverride("window.size=5");
  schema_.ApplyOverride("window.size=6");
  EXPECT_EQ(window_.size, 6);
}

TEST_F(ConfigSchemaTest, EffectiveConfigurationReadsBack) {
  std::mt19937_64 random(3);
  const std::vector<std::string> texts = {"",         "true",
                                          "No",       "3.5",
                                          "-1",       "~",
                                          "null",     "a b",
                                          " lead",    "a: b",
                                          "#x",       "back\\slash",
                                          "\"q\"",    "tab\tnew\nline",
                                          "...",      "---",
                                          "path/f",   "{x}",
                                          "[1, 2]",   "*a",
                                          "&a",       "!t",
                                          "-",        "? k",
                                          "\x01\x7f", "\xc3\xa9tang",
                                          "inf",      ".nan",
                                          "0x1f",     "1e3",
                                          "'",        "%",
                                          "@",        "`",
                                          "1e999"};
  for (const std::string& text : texts) {
    const uint64_t bits = random();
    std::memcpy(&window_.sigma, &bits, sizeof(bits));
    if (!std::isfinite(window_.sigma)) window_.sigma = std::numeric_limits<double>::denorm_min();
    window_.size = static_cast<int>(random());
    matcher_.robust = random() % 2 == 0;
    matcher_.model = text;
    const std::string yaml = schema_.ToYaml();

    MatcherOptions matcher;
    WindowOptions window;
    ConfigSchema reader;
    reader.AddSection("matcher", &matcher);
    reader.AddSection("window", &window);
    std::ofstream(path_, std::ios::binary) << yaml;
    reader.LoadYamlFile(path_);
    EXPECT_EQ(window.sigma, window_.sigma);
    EXPECT_EQ(window.size, window_.size);
    EXPECT_EQ(matcher.robust, matcher_.robust);
    EXPECT_EQ(matcher.model, text) << yaml;
  }
}

TEST_F(ConfigSchemaTest, UnknownSectionNamesTheNearest) {
  EXPECT_EQ(LoadError("\nmacher:\n  alpha_min: 0.5\n"),
            "test.yaml:2: unknown section 'macher'; did you mean 'matcher'?");
  EXPECT_EQ(LoadError("alpha_min: 0.5\n"),
            "test.yaml:1: unknown section 'alpha_min'; it is a key of a section: matcher.alpha_min");
}

TEST_F(ConfigSchemaTest, UnknownKeyNamesTheNearest) {
  EXPECT_EQ(LoadError("matcher:\n  alpha_max: 0.9\n  alpa_min: 0.5\n"),
            "test.yaml:3: unknown key 'alpa_min' in section 'matcher'; did you mean 'alpha_min'?");
  EXPECT_EQ(matcher_.alpha_max, 0.8) << "a file that is refused must change nothing";
  EXPECT_EQ(LoadError("matcher:\n  size: 3\n"),
            "test.yaml:2: unknown key 'size' in section 'matcher'; did you mean window.size?");
}

TEST_F(ConfigSchemaTest, DuplicatesAreErrors) {
  EXPECT_EQ(LoadError("matcher:\n  alpha_min: 0.5\n  alpha_min: 0.6\n"),
            "test.yaml:3: duplicate key 'matcher.alpha_min', first at test.yaml:2; leave only one");
  EXPECT_EQ(LoadError("window:\n  size: 5\nmatcher:\nwindow:\n  sigma: 1\n"),
            "test.yaml:4: duplicate section 'window', first at test.yaml:1; merge the two");
  EXPECT_EQ(window_.size, 15);
}

TEST_F(ConfigSchemaTest, WrongTypesAreErrors) {
  EXPECT_EQ(LoadError("matcher:\n  max_iterations: 3.5\n"),
            "test.yaml:2: matcher.max_iterations is '3.5', expected an integer; its default is 20");
  EXPECT_EQ(LoadError("matcher:\n  alpha_min: high\n"),
            "test.yaml:2: matcher.alpha_min is 'high', expected a finite number; its default is 0.7");
  EXPECT_EQ(LoadError("matcher:\n  robust: yes\n"),
            "test.yaml:2: matcher.robust is 'yes', expected true or false; its default is true");
  EXPECT_EQ(LoadError("matcher:\n  model: 3.5\n"),
            "test.yaml:2: matcher.model is '3.5', expected a string, in quotes; its default is unicycle");
  EXPECT_EQ(LoadError("matcher:\n  alpha_min: \"0.5\"\n"),
            "test.yaml:2: matcher.alpha_min is the string '0.5', expected a finite number; its default is 0.7");
  EXPECT_EQ(LoadError("matcher:\n  alpha_min: [0.5, 0.6]\n"),
            "test.yaml:2: matcher.alpha_min is a list, expected one value without a tag; its default is 0.7");
  EXPECT_EQ(LoadError("matcher:\n  alpha_min:\n"),
            "test.yaml:2: matcher.alpha_min is nothing, expected one value without a tag; its default is 0.7");
  for (const std::string value : {"1e3", "2147483648", "0x10", "", "1 2", "+-3", "++3", "+", "true", "!!int 3"}) {
    EXPECT_NE(LoadError("window:\n  size: " + value + "\n"), "") << value;
  }
  for (const std::string value :
       {"nan", ".nan", ".NaN", "inf", "-.inf", "+.inf", "infinity", "1e999", "-1e999", "1e-999", "0.5m", "0,5", "1_000",
        "0x1p3", "nan(1)", "{a: 1}", "!!float 0.5", "- 1"}) {
    EXPECT_NE(LoadError("window:\n  sigma: " + value + "\n"), "") << value;
  }
  for (const std::string value : {"True", "TRUE", "1", "on", "\"true\"", "truefalse"}) {
    EXPECT_NE(LoadError("matcher:\n  robust: " + value + "\n"), "") << value;
  }
  for (const std::string value : {"true", "~", "null", "[a]", ".nan", "12"}) {
    EXPECT_NE(LoadError("matcher:\n  model: " + value + "\n"), "") << value;
  }
  EXPECT_EQ(schema_.ToYaml(), kDefaultYaml);
}

TEST_F(ConfigSchemaTest, TheStructureMustBeSectionsOfKeys) {
  EXPECT_EQ(LoadError("- a\n- b\n"), "test.yaml:1: holds a list, expected sections with keys; write 'section:' lines");
  EXPECT_EQ(LoadError("hello"), "test.yaml:1: holds 'hello', expected sections with keys; write 'section:' lines");
  EXPECT_EQ(LoadError("matcher: 3\n"),
            "test.yaml:1: section 'matcher' is '3', expected keys with values; write 'key: value' lines below it");
  EXPECT_EQ(LoadError("matcher: {}\n---\nwindow: {}\n"), "test.yaml: holds several YAML documents; leave only one");
  EXPECT_EQ(LoadError("matcher:\n  ? [1, 2]\n  : 3\n"), "test.yaml:2: a key is a list; write keys as plain words");
}

TEST_F(ConfigSchemaTest, BrokenSyntaxNamesTheLine) {
  EXPECT_EQ(LoadError("matcher:\n  alpha_min: 0.5\n  alpha_max: [0.8\nwindow:\n").rfind("test.yaml:", 0), 0u);
  EXPECT_EQ(LoadError("matcher:\n  alpha_min: 0.5\n\talpha_max: 0.8\n").rfind("test.yaml:3: is not valid YAML: ", 0),
            0u);
  EXPECT_NE(LoadError("matcher: *missing\n"), "");
}

TEST_F(ConfigSchemaTest, HostileFilesAreErrorsNotCrashes) {
  EXPECT_NE(LoadError(std::string(10000, '[')), "");
  EXPECT_NE(LoadError(std::string(10000, '{')), "");
  EXPECT_NE(LoadError(std::string("\0\x01\x02PK\x03\x04", 7)), "");
  EXPECT_NE(LoadError("window:\n  size: &a [*a]\n"), "");
  EXPECT_NE(LoadError(std::string("matcher:\n  mo\0del: x\n", 21)), "");
  EXPECT_EQ(LoadError(std::string((1 << 20) + 1, '#')),
            "test.yaml: is longer than 1 MiB, so it is no configuration file; name a YAML file");
  std::mt19937_64 random(4);
  const std::string seed_text = kDefaultYaml;
  for (int i = 0; i < 2000; ++i) {
    std::string text = seed_text;
    for (int change = 0; change < 3; ++change) text[random() % text.size()] = static_cast<char>(random() % 256);
    LoadError(text);
  }
}

TEST_F(ConfigSchemaTest, FilesThatCannotBeReadAreErrors) {
  EXPECT_EQ(ErrorOf([&] { schema_.LoadYamlFile((folder_ / "none.yaml").string()); }),
            "none.yaml: no such configuration file; check the path");
  std::filesystem::create_directory(folder_ / "sub");
  EXPECT_EQ(ErrorOf([&] { schema_.LoadYamlFile((folder_ / "sub").string()); }),
            "sub: is a folder, not a configuration file; name a YAML file");
  if (geteuid() != 0) {
    std::ofstream(path_) << "matcher:\n";
    std::filesystem::permissions(path_, std::filesystem::perms::none);
    EXPECT_EQ(ErrorOf([&] { schema_.LoadYamlFile(path_); }),
              "test.yaml: cannot be read; check that you have the right to read it");
  }
}

TEST_F(ConfigSchemaTest, OverridesSetEveryType) {
  schema_.ApplyOverride("matcher.alpha_min=0.25");
  schema_.ApplyOverride("matcher.max_iterations=3");
  schema_.ApplyOverride("matcher.robust=false");
  schema_.ApplyOverride("matcher.model=a=b # not a comment");
  EXPECT_EQ(matcher_.alpha_min, 0.25);
  EXPECT_EQ(matcher_.max_iterations, 3);
  EXPECT_FALSE(matcher_.robust);
  EXPECT_EQ(matcher_.model, "a=b # not a comment");
  schema_.ApplyOverride("matcher.model=");
  EXPECT_EQ(matcher_.model, "");
}

TEST_F(ConfigSchemaTest, WrongOverridesAreErrors) {
  EXPECT_EQ(OverrideError("matcher.alpha_min"), "--set matcher.alpha_min: has no '='; write it as section.key=value");
  EXPECT_EQ(OverrideError("alpha_min=0.5"),
            "--set alpha_min=0.5: 'alpha_min' names no section; did you mean matcher.alpha_min?");
  EXPECT_EQ(OverrideError("zzz=0.5"), "--set zzz=0.5: 'zzz' names no section; write it as section.key=value");
  EXPECT_EQ(OverrideError("widow.size=4"), "--set widow.size=4: unknown section 'widow'; did you mean 'window'?");
  EXPECT_EQ(OverrideError("window.sizes=4"),
            "--set window.sizes=4: unknown key 'sizes' in section 'window'; did you mean 'size'?");
  EXPECT_EQ(OverrideError("window.size=4.5"),
            "--set window.size=4.5: window.size is '4.5', expected an integer; its default is 15");
  for (const std::string text : {"", "=", ".", ".=", "window.=3", ".size=3", "window.size=", "window.size= 3",
                                 "window.sigma=nan", "matcher.robust=1", "a.b.c=3"}) {
    EXPECT_NE(OverrideError(text), "") << text;
  }
  EXPECT_LT(OverrideError("window.size=" + std::string(100000, 'x')).size(), 300u);
  EXPECT_EQ(schema_.ToYaml(), kDefaultYaml);
}

TEST_F(ConfigSchemaTest, ValidationSaysWhereTheValueCameFrom) {
  Load("window:\n  sigma: 1\nmatcher:\n  alpha_min: 1.3\n");
  EXPECT_EQ(ValidationError(), "test.yaml:4: matcher.alpha_min is 1.3, must lie in (0, 1]; its default is 0.7");
  schema_.ApplyOverride("matcher.alpha_min=0.5");
  EXPECT_EQ(ValidationError(), "");
  schema_.ApplyOverride("window.size=1");
  EXPECT_EQ(ValidationError(), "--set window.size=1: window.size is 1, must be at least 2; its default is 15");
}

TEST_F(ConfigSchemaTest, ValidationOfADefaultThatDoesNotFitTheRest) {
  schema_.ApplyOverride("matcher.alpha_min=0.9");
  EXPECT_EQ(ValidationError(),
            "matcher.alpha_max: alpha_max is 0.8, must be at least alpha_min (it is the default); set it to suit the "
            "other values of section 'matcher'");
}

using ConfigSchemaDeathTest = ConfigSchemaTest;

TEST_F(ConfigSchemaDeathTest, ProgrammerErrorsAreChecks) {
  WindowOptions other;
  EXPECT_DEATH(schema_.AddSection("window", &other), "bound twice");
  EXPECT_DEATH(schema_.AddSection("Bad.Name", &other), "section name");
}

}  // namespace
}  // namespace arborslam
