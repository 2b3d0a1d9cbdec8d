// enamel-figures FIGURES.json FOLDER: draws every figure that the file describes as FOLDER/NAME.png, without a display.
#include <malloc.h>

#include <cstdio>
#include <fstream>

#include "annotations.hpp"
#include "enamel/core/error.hpp"
#include "panel.hpp"
#include "solids.hpp"

namespace {

using namespace enamel::figures;

// {name, size: [width, height], panels: [...], scene: {...}, texts: [...]}
void draw(const Json& figure, const std::string& folder) {
  Canvas canvas({figure.at("size")[0].get<int>(), figure.at("size")[1].get<int>()});
  if (figure.contains("scene")) addSolids(canvas, figure.at("scene"));
  for (const Json& panel : figure.value("panels", Json::array())) addPanel(canvas, panel);
  for (const Json& text : figure.value("texts", Json::array())) addText(canvas, text);
  canvas.write(folder + "/" + figure.at("name").get<std::string>() + ".png");
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fprintf(stderr, "usage: enamel-figures FIGURES.json FOLDER\n");
    return 2;
  }
  try {
    std::ifstream file(argv[1]);
    if (!file) throw enamel::Error(std::string(argv[1]) + ": cannot open the file");
    const Json all = Json::parse(file);
    for (const Json& figure : all.at("figures")) {
      draw(figure, argv[2]);
      malloc_trim(0);  // what a figure took is large and of no use to the next
    }
  } catch (const std::exception& error) {
    std::string message = error.what();
    for (char& c : message)
      if (c == '\n') c = ' ';
    std::fprintf(stderr, "enamel-figures: %s\n", message.c_str());
    return 1;
  }
  return 0;
}
