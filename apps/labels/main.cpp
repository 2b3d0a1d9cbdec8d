// enamel-labels: makes a solid that can be cut from the labels of a CT.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <sstream>
#include <string>
#include <vector>

#include "enamel/collision/solid_file.hpp"
#include "enamel/core/error.hpp"
#include "program/outputs.hpp"
#include "program/program.hpp"
#include "volume.hpp"

namespace enamel::app {
namespace {

struct LabelsOptions {
  std::string file, output;
  std::vector<std::string> layers;
  double smoothing = 0.0;  // mm
  double cell = 0.1;       // mm
  bool overwrite = false;
};

// Read NAME=LABEL,LABEL...@HARDNESS.
LabelLayer layerOf(const std::string& text) {
  LabelLayer layer;
  const std::size_t equals = text.find('='), at = text.find('@');
  char end = ',';
  if (equals != std::string::npos && equals > 0 && at != std::string::npos && at > equals) {
    layer.layer.name = text.substr(0, equals);
    std::istringstream labels(text.substr(equals + 1, at - equals - 1)), hardness(text.substr(at + 1));
    for (int label = 0; end == ',' && labels >> label;) {
      layer.labels.push_back(label);
      if (!labels.get(end)) end = '\0';
    }
    if (end == '\0' && hardness >> layer.layer.hardness && hardness.peek() == std::istringstream::traits_type::eof())
      return layer;
  }
  throw Exit(2, "--layer is \"" + text + "\", must be NAME=LABEL,LABEL...@HARDNESS, for example enamel=1@3.4e9");
}

void run(const LabelsOptions& options) {
  std::vector<LabelLayer> layers;
  for (const std::string& text : options.layers) layers.push_back(layerOf(text));
  const LabelVolume volume = loadLabels(options.file);
  const double smoothing = options.smoothing > 0.0 ? 1e-3 * options.smoothing : volume.spacing.maxCoeff();
  try {
    const Solid solid = solidOf(volume, layers, smoothing, {1e-3 * options.cell, 0});
    saveSolid(solid, options.output);
    std::printf("%s: %d bricks, cells of %g mm\n", options.output.c_str(), solid.bricks(), options.cell);
    const RemovedVolume volumes = solid.volume();
    for (std::size_t k = 0; k < layers.size(); ++k)
      std::printf("%-16s %12.4f mm^3\n", layers[k].layer.name.c_str(), 1e9 * volumes[k]);
  } catch (const Error& error) {
    throw Error(options.file + ": " + error.what());
  }
}

}  // namespace
}  // namespace enamel::app

int main(int argc, char** argv) {
  return enamel::app::runProgram("enamel-labels", [&] {
    using namespace enamel::app;
    LabelsOptions options;
    CLI::App app{"Makes a solid that can be cut (.solid) from the labels of a CT."};
    app.add_option("file", options.file, "volume of labels: NIfTI (.nii, .nii.gz) or NRRD (.nrrd, .nhdr)")->required();
    app.add_option("--layer", options.layers,
                   "layer, outermost first: its name, its labels and its hardness in Pa, as enamel=1@3.4e9")
        ->required()
        ->allow_extra_args(false);
    app.add_option("--smoothing", options.smoothing,
                   "standard deviation of the mean that removes the steps of the voxels, mm; default: the longest edge "
                   "of a voxel")
        ->check(CLI::Range(1e-6, 1e3));
    app.add_option("--cell", options.cell, "edge of the solid's cells, mm")
        ->check(CLI::Range(1e-3, 1e3))
        ->capture_default_str();
    app.add_option("--output", options.output, "file of the solid (.solid)")->required();
    addOverwrite(app, options.overwrite, {"--output"});
    if (parse(app, "enamel-labels", argc, argv)) run(options);
  });
}
