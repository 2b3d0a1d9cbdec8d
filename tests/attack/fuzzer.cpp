// libFuzzer attacks one surface: attack_fuzzer --surface=NAME FOLDER ...; --list names all.
#include <iostream>

#include "surfaces.hpp"

namespace {

enamel::attack::Surface& chosen() {
  static enamel::attack::Surface surface{};
  return surface;
}

}  // namespace

extern "C" int LLVMFuzzerInitialize(int* count, char*** arguments) {
  const std::string_view option = "--surface=";
  for (int i = 1; i < *count; ++i) {
    const std::string_view argument = (*arguments)[i];
    for (const enamel::attack::Surface& surface : enamel::attack::surfaces()) {
      if (argument == "--list") std::cout << surface.name << '\n';
      if (argument.substr(0, option.size()) == option && argument.substr(option.size()) == surface.name)
        chosen() = surface;
    }
    if (argument == "--list") std::exit(0);
  }
  if (chosen().attack == nullptr) {
    std::cerr << "attack_fuzzer: --surface=NAME is missing or unknown; --list names all\n";
    std::exit(2);
  }
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* bytes, std::size_t size) {
  chosen().attack({reinterpret_cast<const char*>(bytes), size});
  return 0;
}
