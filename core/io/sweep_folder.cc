#include "core/io/sweep_folder.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <map>
#include <string_view>
#include <system_error>
#include <tuple>
#include <utility>

#include "core/error.h"
#include "core/io/cloud_layout.h"
#include "core/io/input_file.h"
#include "core/io/kitti_bin.h"
#include "core/io/natural_order.h"
#include "core/io/point_cloud_file.h"
#include "core/io/stamp_repair.h"
#include "core/io/sweep_stamps.h"
#include "core/io/text_reader.h"

namespace arborslam {
namespace {

namespace fs = std::filesystem;

using FilesByKind = std::map<std::string, std::vector<std::string>>;

constexpr double kUsualTurn = 0.1;  // [s]
// A step of the stamps over the span of a sweep's times, when only returns at the ends are missing.
constexpr double kMaxGap = 1.5;
// The span of a sweep's times over what sweeps last: two may be in one file.
constexpr double kMaxSpan = 3.0;
constexpr const char* kSubfolders[] = {"clouds", "velodyne", "velodyne_points/data"};
constexpr const char* kStampFiles[] = {"timestamps.txt", "times.txt"};

std::string LowerCaseExtension(const fs::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

// The sweeps of one folder, by lower-case extension; an empty map when there are none or it is no folder.
FilesByKind SweepsIn(const fs::path& folder) {
  FilesByKind sweeps;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    const fs::path& path = entry->path();
    const std::string extension = LowerCaseExtension(path);
    const bool is_sweep = extension == ".bin" || extension == ".pcd" || extension == ".ply";
    std::error_code ignored;
    if (!is_sweep || path.filename().string().front() == '.' || entry->is_directory(ignored)) continue;
    sweeps[extension].push_back(path.string());
  }
  return sweeps;
}

// Without a slash at the end, so that it has a name and a parent.
fs::path Normal(const std::string& path) {
  const fs::path normal = fs::path(path).lexically_normal();
  return normal.has_filename() || !normal.has_relative_path() ? normal : normal.parent_path();
}

fs::path ParentOf(const fs::path& folder) {
  if (folder.filename() == "." || folder.filename() == "..") return folder / "..";
  return folder.has_parent_path() ? folder.parent_path() : fs::path(".");
}

// To the thousandth.
std::string RoundedText(double value) { return ShortestText(std::round(value * 1e3) / 1e3); }

// Where sweeps may lie, and where their stamps are then.
struct Place {
  fs::path sweeps;
  std::vector<fs::path> stamps;
};

std::vector<Place> Places(const fs::path& folder) {
  std::vector<Place> places;
  for (const char* name : kSubfolders) {
    Place place;
    place.sweeps = folder / name;
    for (fs::path stamps = place.sweeps; stamps != folder; stamps = stamps.parent_path()) {
      place.stamps.push_back(stamps);
    }
    place.stamps.push_back(folder);
    places.push_back(std::move(place));
  }
  places.push_back({folder, {folder, ParentOf(folder)}});
  return places;
}

// The file of stamps in the first of `folders` that has one, or "".
std::string FindStampFile(const std::vector<fs::path>& folders) {
  for (const fs::path& folder : folders) {
    for (const char* name : kStampFiles) {
      std::error_code ignored;
      if (fs::exists(folder / name, ignored)) return (folder / name).string();
    }
  }
  return "";
}

// "3 .bin and 2 .pcd files"
std::string CountText(const FilesByKind& sweeps) {
  std::string text;
  for (const auto& [extension, files] : sweeps) {
    text += (text.empty() ? "" : " and ") + std::to_string(files.size()) + " " + extension;
  }
  return text + " files";
}

std::string NameOf(const std::string& path) { return fs::path(path).filename().string(); }

std::string StemOf(const std::string& path) { return fs::path(path).stem().string(); }

// `stem` with '#' for each of its numbers; the last of these goes to `number`.
std::string PatternOf(std::string_view stem, double* number) {
  constexpr std::string_view kDigits = "0123456789";
  std::string pattern;
  while (!stem.empty()) {
    const size_t begin = std::min(stem.find_first_of(kDigits), stem.size());
    const size_t end = std::min(stem.find_first_not_of(kDigits, begin), stem.size());
    pattern += stem.substr(0, begin);
    if (begin < end) {
      pattern += '#';
      std::from_chars(stem.data() + begin, stem.data() + end, *number);
    }
    stem.remove_prefix(end);
  }
  return pattern;
}

// What is to be told of names that differ in more than their numbers, or, with `by_number`, whose last numbers do not
// rise by the same step: files may be missing. "" for names as they should be.
std::string NumberingNotice(const std::vector<std::string>& files, bool by_number) {
  std::string pattern;
  double number = 0.0;
  double step = 0.0;
  for (size_t i = 0; i < files.size(); ++i) {
    const double last_number = number;
    const std::string last_pattern = std::exchange(pattern, PatternOf(StemOf(files[i]), &number));
    if (i == 0) continue;
    const std::string names = Quoted(NameOf(files[i - 1])) + " and " + Quoted(NameOf(files[i]));
    if (pattern != last_pattern || pattern.find('#') == std::string::npos) {
      return "The sweeps are not named alike (" + names + "); they are taken in the order of their names.";
    }
    if (by_number && i > 1 && number - last_number != step) {
      return "The sweeps are not numbered evenly, first at " + names + "; some may be missing.";
    }
    step = number - last_number;
  }
  return "";
}

PointCloudFile ReadSweepFile(const std::string& path, const BinLayout& layout) {
  if (LowerCaseExtension(path) != ".bin") return ReadPointCloudFile(path);
  PointCloudFile file;
  file.sweep = ReadKittiBin(path, layout);
  return file;
}

// A few files, from the first to the last.
std::vector<std::string> Spread(const std::vector<std::string>& files) {
  constexpr size_t kFew = 5;
  std::vector<std::string> few;
  const size_t count = std::min(files.size(), kFew);
  for (size_t i = 0; i < count; ++i) few.push_back(files[i * (files.size() - 1) / std::max<size_t>(1, count - 1)]);
  return few;
}

// The first file, or the one of the first few that has enough points with times to tell what these mean; its place in
// the order goes to `index`.
PointCloudFile ReadTypicalFile(const std::vector<std::string>& files, const BinLayout& layout, size_t* index) {
  constexpr size_t kFirstFew = 10;
  constexpr size_t kEnough = 100;
  std::optional<PointCloudFile> typical;
  std::optional<UserError> problem;
  for (size_t i = 0; i < std::min(files.size(), kFirstFew); ++i) {
    if (typical && typical->sweep.points.size() >= kEnough) break;
    try {
      PointCloudFile file = ReadSweepFile(files[i], layout);
      if (typical && file.sweep.points.size() <= typical->sweep.points.size()) continue;
      typical = std::move(file);
      *index = i;
    } catch (const UserError& error) {
      if (!problem) problem = error;
    }
  }
  if (!typical) throw UserError(*problem);
  return *std::move(typical);
}

// Whether the times in the last file, no .bin, are absolute by what they are alone: a clock that started with the
// recording gives times that look relative in the first.
bool IsLastAbsolute(const std::vector<std::string>& files, double sweep_duration) {
  try {
    const std::optional<PointTimeFormat> format =
        FindPointTimeFormat(ReadPointCloudFile(files.back()).raw_times, sweep_duration);
    return format && format->is_absolute;
  } catch (const UserError&) {
    return false;  // It is reported when its turn comes, if it does.
  }
}

}  // namespace

bool SweepFolder::Recognises(const std::string& path) {
  std::error_code ignored;
  if (fs::is_directory(path, ignored)) {
    const std::vector<Place> places = Places(Normal(path));
    return std::any_of(places.begin(), places.end(),
                       [](const Place& place) { return !SweepsIn(place.sweeps).empty(); });
  }
  std::ifstream stream = OpenInputFile(path);
  char beginning[16] = {};
  stream.read(beginning, sizeof(beginning));
  const std::string_view read(beginning, static_cast<size_t>(stream.gcount()));
  return LooksLikePcd(read) || LooksLikePly(read) || LowerCaseExtension(path) == ".bin";
}

SweepFolder::SweepFolder(const std::string& path, const SweepFolderOptions& options) : options_(options) {
  const std::string stamp_file = FindFiles(path);
  FindStamps(stamp_file);
  FindLayout();
  FindPointTimes();
}

std::string SweepFolder::FindFiles(const std::string& path) {
  std::error_code ignored;
  if (!fs::is_directory(path, ignored)) {
    files_ = {path};
    return "";
  }
  for (const Place& place : Places(Normal(path))) {
    FilesByKind sweeps = SweepsIn(place.sweeps);
    if (sweeps.empty()) continue;
    if (sweeps.size() > 1) {
      throw UserError(place.sweeps.string(), "holds sweeps of more than one kind (" + CountText(sweeps) + ")",
                      "leave one kind in the folder");
    }
    files_ = std::move(sweeps.begin()->second);
    std::sort(files_.begin(), files_.end(), NaturallyLess);
    return FindStampFile(place.stamps);
  }
  throw UserError(path, "is a folder without sweeps", "give one with files *.bin, *.pcd or *.ply");
}

void SweepFolder::FindStamps(const std::string& stamp_file) {
  const std::vector<double> of_names = SortByStampsOfNames();
  if (stamp_file.empty()) {
    if (of_names.empty()) return;
    notices_.push_back("The sweeps are stamped by the names of their files.");
    TakeStamps(of_names);
    return;
  }
  const SweepStamps stamps = ReadSweepStamps(stamp_file);
  if (stamps.seconds.size() != files_.size()) {
    throw UserError(stamp_file,
                    "has " + std::to_string(stamps.seconds.size()) + " stamps, but there are " +
                        std::to_string(files_.size()) + " sweeps in " + fs::path(files_.front()).parent_path().string(),
                    "give one stamp for each sweep, or move the file away if it is of another recording");
  }
  TakeStamps(stamps.seconds);
  const std::string notice = of_names.empty() ? NumberingNotice(files_, false) : "";
  if (!notice.empty()) notices_.push_back(notice);
}

void SweepFolder::FindLayout() {
  if (LowerCaseExtension(files_.front()) != ".bin") return;
  if (options_.layout != "auto") {
    ParseBinLayout(options_.layout, &layout_);
    return;
  }
  layout_ = FindBinLayout(Spread(files_));
  if (layout_.IsKitti()) return;
  notices_.push_back("The points of the .bin files are " + layout_.Name() +
                     ", x y z first, by what they hold (option input.layout).");
}

void SweepFolder::TakeStamps(std::vector<double> stamps) {
  RepairedStamps repaired = RepairStamps(std::move(stamps), kUsualTurn);
  stamps_ = std::move(repaired.seconds);
  notices_.insert(notices_.end(), repaired.notices.begin(), repaired.notices.end());
}

std::vector<double> SweepFolder::SortByStampsOfNames() {
  std::vector<std::string> stems;
  stems.reserve(files_.size());
  for (const std::string& file : files_) stems.push_back(StemOf(file));
  std::optional<std::vector<double>> stamps = StampsOfNames(stems);
  if (!stamps) return {};
  // 0.2500 comes before 0.300.
  std::vector<std::pair<double, std::string>> stamped;
  for (size_t i = 0; i < files_.size(); ++i) stamped.emplace_back((*stamps)[i], std::move(files_[i]));
  std::sort(stamped.begin(), stamped.end());
  for (size_t i = 0; i < files_.size(); ++i) std::tie((*stamps)[i], files_[i]) = std::move(stamped[i]);
  return *std::move(stamps);
}

void SweepFolder::FindPointTimes() {
  const double rough_duration =
      options_.sweep_duration > 0.0 ? options_.sweep_duration : SweepDurationFromStamps(stamps_).seconds;
  size_t index = 0;
  const PointCloudFile typical = ReadTypicalFile(files_, layout_, &index);
  const std::optional<PointTimeFormat> format = FindPointTimeFormat(typical.raw_times, rough_duration);
  if (format) {
    point_time_format_ = *format;
    notices_.push_back("The times of the points (field '" + typical.time_field + "') are taken for " +
                       format->UnitName() + ".");
  } else if (typical.time_field.empty()) {
    notices_.push_back("The points carry no times.");
  } else {
    notices_.push_back("The times of the points (field '" + typical.time_field +
                       "') span no sweep in any unit; they are not used.");
  }

  std::optional<PointTimeSpan> span;
  if (format) span = SpanOfPointTimes(typical.raw_times, *format, std::numeric_limits<double>::infinity());
  const bool is_absolute = format && (format->is_absolute || IsLastAbsolute(files_, rough_duration));
  if (stamps_.empty() && is_absolute) {
    notices_.push_back("The sweeps are stamped by the times of their first points.");
    next_start_ = span->first - static_cast<double>(index) * rough_duration;
  } else if (stamps_.empty()) {
    AssumeStamps(span ? span->last - span->first : kUsualTurn);
  }
  if (span && !is_absolute) {
    point_clock_ = PointClock::kFromStamp;
  } else if (span) {
    const bool is_on_stamp_clock = !stamps_.empty() && stamps_[index] >= span->first - rough_duration &&
                                   stamps_[index] <= span->last + rough_duration;
    point_clock_ = is_on_stamp_clock ? PointClock::kOfStamps : PointClock::kOther;
  }
  FindDuration(span ? span->last - span->first : 0.0);
}

void SweepFolder::AssumeStamps(double step) {
  for (size_t i = 0; i < files_.size(); ++i) stamps_.push_back(step * static_cast<double>(i));
  if (files_.size() == 1) return;
  notices_.push_back("The recording has no stamps (timestamps.txt or times.txt); its sweeps are taken to be " +
                     RoundedText(step) + " s apart (" + RoundedText(1.0 / step) + " Hz).");
  const std::string notice = NumberingNotice(files_, true);
  if (!notice.empty()) notices_.push_back(notice);
}

void SweepFolder::FindDuration(double span) {
  const SweepDuration of_stamps = SweepDurationFromStamps(stamps_);
  if (options_.sweep_duration > 0.0) {
    duration_ = options_.sweep_duration;
  } else if (span > 0.0) {
    const bool is_turning_on = of_stamps.median_step > span && of_stamps.median_step < kMaxGap * span;
    duration_ = is_turning_on ? of_stamps.median_step : span;
  } else {
    duration_ = of_stamps.seconds;
    is_duration_guessed_ = of_stamps.is_assumed;
    if (of_stamps.is_assumed && of_stamps.median_step > 0.0) {
      notices_.push_back(
          "The stamps are " + RoundedText(of_stamps.median_step) +
          " s apart, longer than most lidars' sweeps last; until the motion tells how long, each is taken to "
          "last " +
          RoundedText(duration_) + " s (option input.sweep_duration).");
    }
  }
  max_span_ = kMaxSpan * std::max(duration_, span);
}

std::optional<Scan> SweepFolder::Next() {
  if (next_ == files_.size()) return std::nullopt;
  PointCloudFile file;
  try {
    file = ReadSweepFile(files_[next_], layout_);
  } catch (const UserError& error) {
    file.sweep.fault = error.what();
  }
  LidarSweep& sweep = file.sweep;
  std::optional<PointTimeSpan> span;
  if (point_clock_ != PointClock::kNone) span = SpanOfPointTimes(file.raw_times, point_time_format_, max_span_);

  const double stamp = !stamps_.empty() ? stamps_[next_] : span ? span->first : next_start_;
  ++next_;
  // The sweep's start on the clock of the points' times.
  double point_start = span ? span->first : 0.0;
  // Whether that and the stamp tell the start together.
  bool is_start_told = stamps_.empty();
  double start = stamp;
  if (span && options_.stamp == "start" &&
      (point_clock_ == PointClock::kFromStamp || point_clock_ == PointClock::kOfStamps)) {
    const double stamp_there = point_clock_ == PointClock::kFromStamp ? 0.0 : stamp;
    const double reach = 2.0 * duration_;
    if (span->first >= stamp_there - reach && span->last <= stamp_there + reach) {
      point_start = std::min(stamp_there, span->first);
      start = stamp + (point_start - stamp_there);
      is_start_told = true;
    }
  }
  sweep.duration = span ? std::max(duration_, span->last - point_start) : duration_;
  if (!is_start_told) {
    sweep.stamp_phase = options_.stamp == "start" ? 0.0 : options_.stamp == "middle" ? 0.5 : 1.0;
    start = stamp - sweep.stamp_phase * sweep.duration;
  }
  sweep.is_duration_guessed = is_duration_guessed_;
  sweep.start = start;
  next_start_ = start + sweep.duration;
  if (span) {
    sweep.times.reserve(file.raw_times.size());
    for (const double raw_time : file.raw_times) {
      sweep.times.push_back(static_cast<float>(raw_time * point_time_format_.unit - point_start));
    }
  }
  return std::move(sweep);
}

}  // namespace arborslam
