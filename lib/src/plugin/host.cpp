#include "enamel/plugin/host.hpp"

#include <algorithm>
#include <filesystem>

#include "convert.hpp"
#include "plugin/library.hpp"

namespace enamel {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kLargestState = std::size_t{16} << 20;  // bytes, of a plugin

void checkTable(const std::string& path, const EnamelPlugin& table) {
  plugin::checkVersion(path, table.abi_version, ENAMEL_OLDEST_ABI_VERSION, ENAMEL_ABI_VERSION);
  plugin::checkSize(path, "EnamelPlugin", table.plugin_size, sizeof(EnamelPlugin));
  plugin::checkSize(path, "EnamelTickInput", table.input_size, sizeof(EnamelTickInput));
  plugin::checkSize(path, "EnamelTickOutput", table.output_size, sizeof(EnamelTickOutput));
  const bool complete = table.describe && table.create && table.configure && table.activate && table.step &&
                        table.reset && table.deactivate && table.destroy && table.state_size && table.save_state &&
                        table.load_state;
  if (!complete) throw PluginError(path + ": a function of its table is missing");
}

// Runs the instance of a plugin behind the C++ contract.
class PluginRenderer final : public Renderer {
 public:
  PluginRenderer(std::shared_ptr<const PluginLibrary> library, const PluginSetup& setup)
      : library_(std::move(library)), table_(library_->table()), self_(table_.create(), table_.destroy) {
    if (!self_) throw PluginError(library_->path() + ": create() failed (no memory)");
    const PlainSetup plain(setup);
    require("configure", [&](EnamelMessage message) { return table_.configure(self_.get(), plain.get(), message); });
  }

 private:
  template <typename Call>
  void require(const char* what, const Call& call) {
    (void)plugin::requireOk(library_->path() + ": " + what + "() failed", what, call);
  }

  void prepare(double period) override {
    if (prepared_) table_.deactivate(self_.get());
    prepared_ = false;
    require("activate", [&](EnamelMessage message) { return table_.activate(self_.get(), period, message); });
    prepared_ = true;
    const std::size_t size = table_.state_size(self_.get());
    if (size > kLargestState)
      throw PluginError(library_->path() + ": its state has " + std::to_string(size) + " bytes, must be at most " +
                        std::to_string(kLargestState));
    state_.assign(size, 0);
  }

  bool needsInertia() const noexcept override { return (table_.needs & ENAMEL_NEEDS_INERTIA) != 0; }

  Status render(const TickFrame& input, TickOutput& output) noexcept override {
    toPlain(input, input_);
    if (table_.abi_version < ENAMEL_ABI_VERSION && input_.applied_known == ENAMEL_APPLIED_SENT)
      input_.applied_known = ENAMEL_APPLIED_UNKNOWN;  // it would take it for a report
    const std::int32_t result = table_.step(self_.get(), &input_, &output_);
    if (result < ENAMEL_OK || result > ENAMEL_INACTIVE) return Status::inactive;  // not a status of a tick
    if (result != ENAMEL_OK) return static_cast<Status>(result);
    if (output_.answer == ENAMEL_WRENCH)
      output.torque = staticTorque(input.kinematics, Eigen::Map<const Vec6>(output_.wrench));
    else
      fromPlain(output_.torque, static_cast<int>(input.kinematics.q.size()), output.torque);
    output.normalForce = output_.normal_force;
    output.mode = output_.mode == ENAMEL_CONTACT ? RenderMode::contact : RenderMode::free;
    output.saturated = output_.saturated != 0;
    return Status::ok;
  }

  void resetState() noexcept override { table_.reset(self_.get()); }

  StateBlock stateBlock() noexcept override {
    table_.save_state(self_.get(), state_.data());
    return {state_.data(), state_.size()};
  }

  void stateLoaded() noexcept override { table_.load_state(self_.get(), state_.data()); }

  std::shared_ptr<const PluginLibrary> library_;
  const EnamelPlugin& table_;
  std::unique_ptr<void, void (*)(void*)> self_;
  bool prepared_ = false;
  std::vector<unsigned char> state_;
  EnamelTickInput input_{};
  EnamelTickOutput output_{};
};

}  // namespace

void PluginLibrary::use(const EnamelPlugin& table) {
  checkTable(path_, table);
  table_ = &table;
  description_ = plugin::guarded(path_, "describe", table.describe);
  plugin::checkDescription(path_, description_);
}

std::shared_ptr<const PluginLibrary> PluginLibrary::of(const EnamelPlugin& table, const std::string& name) {
  std::shared_ptr<PluginLibrary> library(new PluginLibrary);
  library->path_ = name;
  library->use(table);
  return library;
}

std::shared_ptr<const PluginLibrary> PluginLibrary::load(const std::string& path) {
  std::shared_ptr<PluginLibrary> library(new PluginLibrary);
  library->path_ = path;
  library->handle_ = plugin::loadShared(path);
  library->use(plugin::tableOf<EnamelPlugin>(path, library->handle_.get(), ENAMEL_PLUGIN_SYMBOL));
  return library;
}

std::unique_ptr<Renderer> makeRenderer(std::shared_ptr<const PluginLibrary> library, const PluginSetup& setup) {
  return std::make_unique<PluginRenderer>(std::move(library), setup);
}

std::vector<std::string> pluginFiles(const std::string& folder) {
  std::vector<std::string> files;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(fs::u8path(folder), error))
    if (entry.path().extension() == system::kLibraryEnding) files.push_back(entry.path().generic_u8string());
  if (error) throw PluginError(folder + ": cannot read the folder: " + error.message());
  std::sort(files.begin(), files.end());
  return files;
}

std::vector<PluginFinding> findPlugins(const std::string& folder) {
  std::vector<PluginFinding> findings;
  for (const std::string& file : pluginFiles(folder)) findings.push_back({file, nullptr, ""});
  for (PluginFinding& finding : findings) {
    try {
      finding.library = PluginLibrary::load(finding.path);
    } catch (const PluginError& refused) {
      finding.reason = refused.what();
    }
  }
  return findings;
}

std::shared_ptr<const PluginLibrary> findPlugin(const std::string& nameOrPath, const std::string& folder) {
  return plugin::find<PluginLibrary>("plugin", nameOrPath, folder);
}

}  // namespace enamel
