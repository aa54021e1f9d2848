#include "apps/offline/loaded_session.h"

#include "backend/store/session_reader.h"
#include "core/config/config_schema.h"

namespace arborslam {

OfflineOptions SessionOptions(const std::string& config, const std::string& path) {
  OfflineOptions options;
  ConfigSchema schema;
  options.VisitSections([&schema](const std::string& name, auto& section) { schema.AddSection(name, &section); });
  schema.LoadYaml(config, path + ", options");
  schema.ValidateAll();
  return options;
}

LoadedSession LoadSession(const std::string& path) {
  return LoadSession(path, MakeStore(SessionOptions(ReadSessionSummary(path).config, path).memory));
}

LoadedSession LoadSession(const std::string& path, const std::shared_ptr<ValueStore>& store) {
  const OfflineOptions options = SessionOptions(ReadSessionSummary(path).config, path);
  return {options, Completed(ReadSession(path, store), options.slam, path)};
}

}  // namespace arborslam
