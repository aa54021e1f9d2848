#include "core/io/sweep_folder.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <map>
#include <numeric>
#include <optional>
#include <system_error>
#include <utility>

#include "core/error.h"
#include "core/io/input_file.h"
#include "core/io/kitti_bin.h"
#include "core/io/natural_order.h"
#include "core/io/sweep_stamps.h"
#include "core/io/text_reader.h"

namespace arborslam {
namespace {

namespace fs = std::filesystem;

constexpr double kAssumedStep = 0.1;  // [s]
constexpr const char* kSubfolders[] = {"clouds", "velodyne", "velodyne_points/data"};
constexpr const char* kStampFiles[] = {"timestamps.txt", "times.txt"};

std::string LowerCaseExtension(const fs::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

bool IsSweepExtension(const std::string& extension) { return extension == ".bin"; }

// The sweeps of one folder, by lower-case extension; an empty map when there are none or it is no folder.
std::map<std::string, std::vector<std::string>> SweepsIn(const fs::path& folder) {
  std::map<std::string, std::vector<std::string>> sweeps;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    const fs::path& path = entry->path();
    const std::string extension = LowerCaseExtension(path);
    std::error_code ignored;
    if (!IsSweepExtension(extension) || path.filename().string().front() == '.' || entry->is_directory(ignored)) {
      continue;
    }
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

// Where sweeps are looked for, and where their stamps are then.
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

std::vector<std::string> Stems(const std::vector<std::string>& files) {
  std::vector<std::string> stems;
  stems.reserve(files.size());
  for (const std::string& file : files) stems.push_back(fs::path(file).stem().string());
  return stems;
}

LidarSweep ReadSweep(const std::string& path) { return ReadKittiBin(path); }

}  // namespace

bool SweepFolder::Recognises(const std::string& path) {
  std::error_code ignored;
  if (!fs::is_directory(path, ignored)) return IsSweepExtension(LowerCaseExtension(path));
  const std::vector<Place> places = Places(Normal(path));
  return std::any_of(places.begin(), places.end(), [](const Place& place) { return !SweepsIn(place.sweeps).empty(); });
}

SweepFolder::SweepFolder(const std::string& path, const SweepFolderOptions& options) : options_(options) {
  std::string stamps_path;
  std::error_code ignored;
  if (fs::is_directory(path, ignored)) {
    const std::vector<Place> places = Places(Normal(path));
    std::map<std::string, std::vector<std::string>> sweeps;
    for (const Place& place : places) {
      sweeps = SweepsIn(place.sweeps);
      if (sweeps.empty()) continue;
      stamps_path = FindStampFile(place.stamps);
      break;
    }
    if (sweeps.empty()) throw UserError(path, "is a folder without sweeps", "give one with files *.bin");
    files_ = std::move(sweeps.begin()->second);
    std::sort(files_.begin(), files_.end(), NaturallyLess);
  } else {
    files_ = {path};
  }
  ReadStamps(stamps_path);
  FindDuration();
  ReadSweep(files_.front());
}

void SweepFolder::ReadStamps(const std::string& stamps_path) {
  if (!stamps_path.empty()) {
    const SweepStamps stamps = ReadSweepStamps(stamps_path);
    if (stamps.seconds.size() != files_.size()) {
      throw UserError(stamps_path,
                      "has " + std::to_string(stamps.seconds.size()) + " stamps, but there are " +
                          std::to_string(files_.size()) + " sweeps in " +
                          fs::path(files_.front()).parent_path().string(),
                      "give one stamp for each sweep, or move the file away if it is of another recording");
    }
    size_t num_backwards = 0;
    size_t first_line = 0;
    for (size_t i = 1; i < stamps.seconds.size(); ++i) {
      if (stamps.seconds[i] > stamps.seconds[i - 1]) continue;
      if (num_backwards++ == 0) first_line = stamps.line_numbers[i];
    }
    if (num_backwards > 0) {
      notices_.push_back(std::to_string(num_backwards) + " of the " + std::to_string(files_.size()) + " stamps in " +
                         stamps_path + " are not later than the one before, the first in line " +
                         std::to_string(first_line) + ".");
    }
    stamps_ = stamps.seconds;
    return;
  }
  if (std::optional<std::vector<double>> stamps = StampsOfNames(Stems(files_))) {
    // A fraction is no whole number: 0.25 before 0.3.
    std::vector<size_t> order(files_.size());
    std::iota(order.begin(), order.end(), size_t{0});
    std::sort(order.begin(), order.end(), [&](size_t a, size_t b) { return (*stamps)[a] < (*stamps)[b]; });
    std::vector<std::string> files;
    for (const size_t i : order) {
      files.push_back(files_[i]);
      stamps_.push_back((*stamps)[i]);
    }
    files_ = std::move(files);
    notices_.push_back("The sweeps are stamped by the names of their files.");
    return;
  }
  for (size_t i = 0; i < files_.size(); ++i) stamps_.push_back(kAssumedStep * static_cast<double>(i));
  if (files_.size() > 1) {
    notices_.push_back(
        "The recording has no stamps (timestamps.txt or times.txt); its sweeps are taken to be 0.1 s apart (10 Hz).");
  }
}

void SweepFolder::FindDuration() {
  duration_ = options_.sweep_duration;
  if (duration_ > 0.0) return;
  const SweepDuration duration = SweepDurationFromStamps(stamps_);
  duration_ = duration.seconds;
  if (duration.is_assumed && duration.median_step > 0.0) {
    notices_.push_back("The stamps are " + ShortestText(duration.median_step) +
                       " s apart, longer than a sweep lasts; each sweep is taken to last " + ShortestText(duration_) +
                       " s (see sweep_duration).");
  }
}

std::optional<Scan> SweepFolder::Next() {
  if (next_ == files_.size()) return std::nullopt;
  LidarSweep sweep = ReadSweep(files_[next_]);
  sweep.duration = duration_;
  const double into_sweep = options_.stamp == "start" ? 0.0 : options_.stamp == "middle" ? 0.5 : 1.0;
  sweep.start = stamps_[next_] - into_sweep * sweep.duration;
  ++next_;
  return sweep;
}

}  // namespace arborslam
