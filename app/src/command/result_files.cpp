#include "command/result_files.hpp"

#include "figure/page.hpp"
#include "system/output.hpp"
#include "tendril/app/figure.hpp"
#include "tendril/app/files.hpp"
#include "tendril/app/input_error.hpp"

namespace tendril::app {

namespace {

void draw(const ResultForms& forms, const std::filesystem::path& directory, const std::string& stem,
          const std::vector<Picture>& pictures) {
  if (!forms.draw) return note("no figure: " + forms.no_shape);
  StagedFiles files(directory);
  forms.draw(files, stem, pictures);
  files.publish();
}

}  // namespace

void try_places(const ResultPlaces& places) {
  if (places.figure) {
    picture_of(*places.figure);
    const StagedFiles trial(places.figure->parent_path());
  }
  if (places.output) const StagedFiles trial(*places.output);
}

void give_result(const ResultPlaces& places, const ResultForms& forms, Session& session) {
  const std::string json = places.json || places.output ? forms.json() : "";
  if (places.output) {
    {
      StagedFiles files(*places.output);
      files.write("result.json", json);
      files.publish();
    }
    try {
      draw(forms, *places.output, "figure", {Picture::svg, Picture::png});
    } catch (const InputError& error) {
      note(error.what());
    }
  }
  if (places.figure && picture_of(*places.figure) == Picture::page && forms.draw) {
    write_page(*places.figure, Json::parse(forms.json()), "the result", session.registry());
  } else if (places.figure) {
    draw(forms, places.figure->parent_path(), places.figure->stem().string(), {picture_of(*places.figure)});
  }
  print(places.json ? json : forms.report());
}

}  // namespace tendril::app
