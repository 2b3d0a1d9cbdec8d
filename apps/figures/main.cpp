// enamel-figures FIGURES.json FOLDER: draws every figure that the file describes as FOLDER/NAME.png, without a display.
#include <malloc.h>

#include "annotations.hpp"
#include "enamel/core/error.hpp"
#include "enamel/core/file.hpp"
#include "panel.hpp"
#include "program.hpp"
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
  return enamel::app::runProgram("enamel-figures", [&] {
    if (argc != 3) throw enamel::app::Exit(2, "usage: enamel-figures FIGURES.json FOLDER");
    const Json all = Json::parse(enamel::readJson(argv[1]), nullptr, false);
    if (!all.is_object() || !all.contains("figures"))
      throw enamel::ConfigurationError(argv[1], 0, "", "describes no figures");
    for (const Json& figure : all.at("figures")) {
      try {
        draw(figure, argv[2]);
      } catch (const Json::exception&) {
        throw enamel::ConfigurationError(argv[1], 0, "figures",
                                         "has a description that cannot be drawn: see panel.hpp");
      }
      malloc_trim(0);  // what a figure took is large and of no use to the next
    }
  });
}
