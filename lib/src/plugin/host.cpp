#include "enamel/plugin/host.hpp"

#include <dlfcn.h>
#include <elf.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "convert.hpp"

namespace enamel {
namespace {

constexpr std::size_t kLargestState = std::size_t{16} << 20;  // bytes, of a plugin

#if defined(__x86_64__)
constexpr int kMachine = EM_X86_64;
#elif defined(__aarch64__)
constexpr int kMachine = EM_AARCH64;
#else
constexpr int kMachine = EM_NONE;  // not checked
#endif

std::string machineName(int machine) {
  switch (machine) {
    case EM_X86_64: return "x86-64";
    case EM_AARCH64: return "AArch64";
    case EM_386: return "x86 of 32 bits";
    case EM_ARM: return "ARM of 32 bits";
    case EM_RISCV: return "RISC-V";
    default: return "ELF machine " + std::to_string(machine);
  }
}

// The file's header permits a better message than the loader's.
void checkFile(const std::string& path) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored)) throw PluginError(path + ": no such file");
  Elf64_Ehdr head{};
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  const auto size = static_cast<std::uint64_t>(std::max<std::streamoff>(file.tellg(), 0));
  const auto readAt = [&](std::uint64_t at, auto& into) {
    file.seekg(static_cast<std::streamoff>(at));
    return static_cast<bool>(file.read(reinterpret_cast<char*>(&into), sizeof into));
  };
  if (!readAt(0, head) || std::memcmp(head.e_ident, ELFMAG, SELFMAG) != 0)
    throw PluginError(path + ": is not a shared library (its ELF header is missing)");
  if (kMachine != EM_NONE && head.e_machine != kMachine)
    throw PluginError(path + ": is built for " + machineName(head.e_machine) + ", this host for " +
                      machineName(kMachine));
  if (head.e_type != ET_DYN || head.e_ident[EI_CLASS] != ELFCLASS64 || head.e_phentsize != sizeof(Elf64_Phdr))
    throw PluginError(path + ": is not a shared library");
  // The loader maps what the header promises. Past the end of the file that is a bus error.
  for (std::uint64_t i = 0; i < head.e_phnum; ++i) {
    Elf64_Phdr part{};
    const std::uint64_t at = head.e_phoff + i * sizeof part;
    if (at >= size || !readAt(at, part) || part.p_offset > size || part.p_filesz > size - part.p_offset)
      throw PluginError(path + ": is truncated: it has " + std::to_string(size) + " bytes, its header declares more");
  }
}

void checkSize(const std::string& path, const char* what, std::uint32_t found, std::size_t expected) {
  if (found != expected)
    throw PluginError(path + ": its " + what + " has " + std::to_string(found) + " bytes, this host's " +
                      std::to_string(expected));
}

void checkTable(const std::string& path, const EnamelPlugin& table) {
  if (table.abi_version < ENAMEL_OLDEST_ABI_VERSION || table.abi_version > ENAMEL_ABI_VERSION)
    throw PluginError(path + ": has ABI version " + std::to_string(table.abi_version) + ", this host loads " +
                      std::to_string(ENAMEL_OLDEST_ABI_VERSION) + " to " + std::to_string(ENAMEL_ABI_VERSION) +
                      ": build the plugin with this version's headers");
  checkSize(path, "EnamelPlugin", table.plugin_size, sizeof(EnamelPlugin));
  checkSize(path, "EnamelTickInput", table.input_size, sizeof(EnamelTickInput));
  checkSize(path, "EnamelTickOutput", table.output_size, sizeof(EnamelTickOutput));
  const bool complete = table.describe && table.create && table.configure && table.activate && table.step &&
                        table.reset && table.deactivate && table.destroy && table.state_size && table.save_state &&
                        table.load_state;
  if (!complete) throw PluginError(path + ": a function of its table is missing");
}

void checkDescription(const std::string& path, const EnamelDescription* d) {
  const auto isLine = [](const char* text) { return text != nullptr && printable(text) == text; };
  const auto filled = [isLine](const char* text) { return isLine(text) && *text != 0; };
  if (d == nullptr || !filled(d->name) || !filled(d->version) || !filled(d->summary))
    throw PluginError(path + ": name, version and summary of its description must each be one line");
  const std::string name = d->name;
  if (!std::all_of(name.begin(), name.end(), [](unsigned char c) { return std::isalnum(c) || c == '-'; }))
    throw PluginError(path + ": its name \"" + name + "\" has characters other than letters, digits and '-'");
  if (d->parameter_count > 0 && d->parameters == nullptr)
    throw PluginError(path + ": its description declares " + std::to_string(d->parameter_count) +
                      " parameters, but its list is NULL");
  for (std::size_t i = 0; i < d->parameter_count; ++i)
    if (!filled(d->parameters[i].key) || !isLine(d->parameters[i].value) || !filled(d->parameters[i].meaning))
      throw PluginError(path + ": parameter " + std::to_string(i) +
                        " must have a key and a meaning of one line each, and a default");
}

// The contract forbids exceptions. If a plugin throws one, report it instead of ending this program.
template <typename Result>
Result guarded(const std::string& path, const std::string& what, Result (*function)()) {
  try {
    return function();
  } catch (const std::exception& error) {
    throw PluginError(path + ": " + what + "() threw: " + error.what());
  } catch (...) {
    throw PluginError(path + ": " + what + "() threw an unknown exception");
  }
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
    std::array<char, 1024> text{};
    const std::int32_t result = call(EnamelMessage{text.data(), text.size()});
    text.back() = 0;
    if (result != ENAMEL_OK)
      throw PluginError(library_->path() + ": " + what + "() failed with code " + std::to_string(result) +
                        (text[0] != 0 ? ": " : "") + text.data());
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
  description_ = guarded(path_, "describe", table.describe);
  checkDescription(path_, description_);
}

std::shared_ptr<const PluginLibrary> PluginLibrary::of(const EnamelPlugin& table, const std::string& name) {
  std::shared_ptr<PluginLibrary> library(new PluginLibrary);
  library->path_ = name;
  library->use(table);
  return library;
}

std::shared_ptr<const PluginLibrary> PluginLibrary::load(const std::string& path) {
  checkFile(path);
  std::shared_ptr<PluginLibrary> library(new PluginLibrary);
  library->path_ = path;
  // A name without '/' would be searched for in the system's folders.
  library->handle_ = dlopen(std::filesystem::absolute(path).c_str(), RTLD_NOW | RTLD_LOCAL);
  if (library->handle_ == nullptr) throw PluginError(path + ": cannot be loaded: " + dlerror());
  void* symbol = dlsym(library->handle_, ENAMEL_PLUGIN_SYMBOL);
  if (symbol == nullptr) throw PluginError(path + ": does not export " ENAMEL_PLUGIN_SYMBOL "()");
  const EnamelPlugin* table = guarded(path, ENAMEL_PLUGIN_SYMBOL, reinterpret_cast<const EnamelPlugin* (*)()>(symbol));
  if (table == nullptr) throw PluginError(path + ": " ENAMEL_PLUGIN_SYMBOL "() returned NULL");
  library->use(*table);
  return library;
}

PluginLibrary::~PluginLibrary() {
  if (handle_ != nullptr) dlclose(handle_);
}

std::unique_ptr<Renderer> makeRenderer(std::shared_ptr<const PluginLibrary> library, const PluginSetup& setup) {
  return std::make_unique<PluginRenderer>(std::move(library), setup);
}

std::vector<std::string> pluginFiles(const std::string& folder) {
  std::vector<std::string> files;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error))
    if (entry.path().extension() == ".so") files.push_back(entry.path().string());
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
  const std::string ending = ".so";
  const bool isFile = nameOrPath.size() > ending.size() &&
                      nameOrPath.compare(nameOrPath.size() - ending.size(), ending.size(), ending) == 0;
  if (isFile || nameOrPath.find('/') != std::string::npos) return PluginLibrary::load(nameOrPath);
  std::string known, stem = nameOrPath;
  std::replace(stem.begin(), stem.end(), '-', '_');
  std::error_code ignored;
  // The likely files come first, so that a bad plugin beside them is not loaded.
  for (const std::string& file : {folder + "/enamel_" + stem + ending, folder + "/" + stem + ending}) {
    if (!std::filesystem::is_regular_file(file, ignored)) continue;
    auto library = PluginLibrary::load(file);
    if (library->description().name == nameOrPath) return library;
  }
  if (std::filesystem::is_directory(folder, ignored))
    for (const PluginFinding& finding : findPlugins(folder)) {
      if (!finding.library) continue;
      if (finding.library->description().name == nameOrPath) return finding.library;
      known += std::string(known.empty() ? "" : ", ") + finding.library->description().name;
    }
  const std::string found = folder.empty()  ? "no plugin folder is given"
                            : known.empty() ? folder + " has no plugins"
                                            : folder + " has " + known;
  throw PluginError("unknown plugin \"" + nameOrPath + "\": " + found + "; a path must end in .so");
}

}  // namespace enamel
