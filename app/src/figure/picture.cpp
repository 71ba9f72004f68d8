#include "figure/picture.hpp"

#include "figure/frame_figure.hpp"
#include "figure/movie.hpp"
#include "figure/page.hpp"
#include "figure/panels.hpp"
#include "tendril/app/input_error.hpp"

namespace tendril::app {

void require_name(const std::filesystem::path& file, const std::string& what) {
  const std::string name = file.filename().string();
  for (const char c : name) {
    if ((c >= 0 && c < ' ') || c == 127)
      throw InputError("the name of the " + what + " holds a control character, expected printable text");
  }
  if (name.find("''") != std::string::npos)
    throw InputError("the name of the " + what + " holds two quotes in a row, which gnuplot cannot read");
}

Picture picture_of(const std::filesystem::path& file) {
  require_name(file, "figure");
  const std::string extension = file.extension().string();
  if (extension == ".svg") return Picture::svg;
  if (extension == ".png") return Picture::png;
  if (extension == ".pdf") return Picture::pdf;
  if (extension == ".html") return Picture::page;
  throw InputError("found the figure '" + file.filename().string() +
                   "', expected a name that ends in .svg, .png, .pdf or .html");
}

void draw_pictures(const Json& drawing, StagedFiles& files, const std::string& stem,
                   const std::vector<Picture>& pictures) {
  if (drawing.contains("ordered")) {
    ShapePanel panel(drawing);
    panel.ordered = true;
    for (const Json& frame : drawing["frames"]) panel.add(frame);
    return draw_panels(drawing["title"], {{panel}}, {}, LoopPanel::of(drawing), files, stem, pictures);
  }
  if (drawing["problem"] == "study") {
    throw InputError("no figure: a study is drawn by 'tendril study --figure', expected .html, .gif or .mp4 here");
  }
  const std::size_t last = drawing["frames"].size() - 1;
  const FrameFigure figure(drawing, {last}, gnuplot_file(stem + ".dat"));
  render({figure.data(), figure.settings(), figure.draw(last, false), "replot\n", figure.width(), figure.height()},
         files, stem, pictures);
}

void write_picture(const std::filesystem::path& file, const Json& drawing, const std::atomic<bool>* stop) {
  if (is_movie(file)) return write_movie(file, drawing, stop);
  const Picture picture = picture_of(file);
  StagedFiles files(file.parent_path());
  if (picture == Picture::page) {
    files.write(file.filename().string(), drawing_page(drawing));
  } else {
    draw_pictures(drawing, files, file.stem().string(), {picture});
  }
  files.publish();
}

}  // namespace tendril::app
