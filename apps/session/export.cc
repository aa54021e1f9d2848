#include <filesystem>
#include <iostream>
#include <string>
#include <vector>

#include "apps/common/output_folder.h"
#include "apps/offline/loaded_session.h"
#include "apps/session/commands.h"
#include "apps/session/session_outputs.h"
#include "core/error.h"

namespace arborslam {

int SessionExport(const std::string& path, const std::string& folder_name) {
  const LoadedSession session = LoadSession(path);
  if (session.contents.keyframes.empty()) throw UserError(path, "holds no keyframes yet", "nothing was written");
  const std::vector<std::string> names = SessionOutputNames(session.contents.recordings.size());
  const std::filesystem::path folder = PrepareOutputFolder(folder_name, names, {path});
  WriteSessionOutputs(folder, session);
  std::string list;
  for (size_t i = 0; i < names.size(); ++i) {
    list += (i == 0 ? "" : i + 1 < names.size() ? ", " : " and ") + names[i];
  }
  std::cout << list << " are in " << folder.string() << "\n";
  return 0;
}

}  // namespace arborslam
