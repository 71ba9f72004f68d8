#include "command/result_files.hpp"

#include "figure/drawing.hpp"
#include "figure/movie.hpp"
#include "figure/picture.hpp"
#include "system/output.hpp"
#include "tendril/app/input_error.hpp"

namespace tendril::app {

namespace {

/// The pictures of a result, of which the drawing is made once.
class Pictures {
 public:
  Pictures(const ResultForms& forms, Session& session, std::vector<std::string>& notes)
      : forms_(forms), session_(session), notes_(notes) {}

  void into(const std::filesystem::path& directory, const std::string& stem, const std::vector<Picture>& pictures) {
    if (!forms_.draw && !drawing()) return;
    StagedFiles files(directory);
    if (!forms_.draw) {
      draw_pictures(*drawing(), files, stem, pictures);
    } else if (!forms_.draw(files, stem, pictures)) {
      return no_shape();
    }
    files.publish();
  }
  void as(const std::filesystem::path& file) {
    if (forms_.draw) return into(file.parent_path(), file.stem().string(), {picture_of(file)});
    if (drawing()) write_picture(file, *drawing());
  }

 private:
  void no_shape() { notes_.push_back("no figure: " + forms_.no_shape); }
  /// Null: there is no shape, which was said.
  const Json* drawing() {
    if (!made_) {
      made_ = true;
      drawing_ = drawing_of(Json::parse(forms_.json()), "the result", session_.registry());
      if (!has_shape(drawing_)) {
        drawing_ = nullptr;
        no_shape();
      }
    }
    return drawing_.is_null() ? nullptr : &drawing_;
  }

  const ResultForms& forms_;
  Session& session_;
  std::vector<std::string>& notes_;
  bool made_ = false;
  Json drawing_;
};

}  // namespace

void try_places(const ResultPlaces& places) {
  if (places.figure) picture_of(*places.figure);
  if (places.movie) require_movie(*places.movie);
  for (const auto& file : {places.figure, places.movie}) {
    if (file) const StagedFiles trial(file->parent_path());
  }
  if (places.output) const StagedFiles trial(*places.output);
}

std::vector<std::string> write_result(const ResultPlaces& places, const ResultForms& forms, Session& session) {
  std::vector<std::string> notes;
  Pictures pictures(forms, session, notes);
  if (places.output) {
    {
      StagedFiles files(*places.output);
      files.write("result.json", forms.json());
      files.publish();
    }
    try {
      pictures.into(*places.output, "figure", {Picture::svg, Picture::png});
    } catch (const InputError& error) {
      notes.emplace_back(error.what());
    }
  }
  for (const auto& file : {places.figure, places.movie}) {
    if (file) pictures.as(*file);
  }
  return notes;
}

void give_result(const ResultPlaces& places, const ResultForms& forms, Session& session) {
  for (const std::string& text : write_result(places, forms, session)) note(text);
  print(places.json ? forms.json() : forms.report());
}

}  // namespace tendril::app
