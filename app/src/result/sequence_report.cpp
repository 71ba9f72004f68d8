#include "result/sequence_report.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "result/fit_parts.hpp"

namespace tendril::app {

namespace {

/// Of more frames than these a table shows some.
constexpr std::size_t most_rows = 40;

Json known_json(const EstimatedContact& c) {
  return {{"force", number(c.force)},
          {"force_error", number(c.force_error)},
          {"arc_length", number(c.arc_length)},
          {"arc_length_error", number(c.arc_length_error)},
          {"correlation", number(c.correlation)}};
}

Json contact_json(const FollowedContact& contact) {
  const EstimatedContact& c = contact.all;
  Json json = {{"number", contact.number}};
  json.update(known_json(c));
  json["point"] = numbers({c.point.x, c.point.y});
  json["normal"] = numbers({c.normal.x, c.normal.y});
  json["at_tip"] = c.at_tip;
  json["identifiable"] = c.identifiable;
  json["reason"] = c.reason;
  if (c.friction) json["friction_range"] = friction_json(*c.friction);
  json["so_far"] = known_json(contact.so_far);
  return json;
}

Json frame_json(const EstimatedFrame& frame, bool timed) {
  Json json = {{timed ? "time" : "frame", number(frame.time)},
               {"status", to_string(frame.status)},
               {"moments", numbers(frame.moments)},
               {"contacts", Json::array()},
               {"made", frame.made},
               {"broken", frame.broken},
               {"residual_rms", number(frame.residual_rms)},
               {"chi2", number(frame.chi_square)},
               {"degrees_of_freedom", frame.degrees_of_freedom},
               {"fit_probability", number(frame.fit_probability)},
               {"surprise",
                {{"chi2", number(frame.surprise)},
                 {"degrees_of_freedom", frame.surprise_degrees},
                 {"probability", number(frame.surprise_probability)}}}};
  for (const FollowedContact& c : frame.contacts) json["contacts"].push_back(contact_json(c));
  return json;
}

std::string when(const SequenceEstimate& estimate, double time) { return shown(time) + (estimate.timed ? " s" : ""); }

/// Each contact while it is there.
std::string contacts_text(const SequenceEstimate& estimate, const DisplayUnits& units) {
  struct Life {
    const EstimatedFrame *first = nullptr, *last = nullptr;
    int frames = 0;
    double least = infinity, most = 0.0, from = 0.0, to = 0.0;
  };
  std::vector<Life> lives;
  for (const EstimatedFrame& frame : estimate.frames) {
    for (const FollowedContact& c : frame.contacts) {
      lives.resize(std::max(lives.size(), static_cast<std::size_t>(c.number)));
      Life& life = lives[static_cast<std::size_t>(c.number - 1)];
      if (life.frames++ == 0) {
        life.first = &frame;
        life.from = c.all.arc_length;
      }
      life.last = &frame;
      life.to = c.all.arc_length;
      life.least = std::min(life.least, c.all.force);
      life.most = std::max(life.most, c.all.force);
    }
  }
  if (lives.empty()) return "\nno frame shows a contact\n";
  Grid grid;
  grid.row({"contact", "first frame", "last frame", "frames", "least force", "largest force", "first arc length",
            "last arc length"});
  for (std::size_t i = 0; i < lives.size(); ++i) {
    const Life& life = lives[i];
    if (life.frames == 0) continue;
    grid.row({std::to_string(i + 1), when(estimate, life.first->time), when(estimate, life.last->time),
              std::to_string(life.frames), force(life.least), force(life.most), units.lengths(life.from),
              units.lengths(life.to)});
  }
  return '\n' + grid.text("");
}

std::string frames_text(const SequenceEstimate& estimate, const DisplayUnits& units) {
  const std::size_t step = (estimate.frames.size() + most_rows - 1) / most_rows;
  const auto lengths = [&](double v) { return units.lengths(v); };
  const auto rubs = [](const EstimatedFrame& f) {
    return std::any_of(f.contacts.begin(), f.contacts.end(), [](const FollowedContact& c) { return c.all.friction; });
  };
  const bool rough = std::any_of(estimate.frames.begin(), estimate.frames.end(), rubs);
  Grid grid;
  const auto add_row = [&](std::vector<std::string> cells, const std::optional<EstimatedFriction>& friction) {
    if (!rough) cells.resize(8);
    if (friction) {
      cells[8] = interval_text(friction->force, [](double v) { return force(v); });
      cells[9] = interval_text(friction->arc_length, lengths);
    }
    grid.row(cells);
  };
  add_row({estimate.timed ? "time" : "frame", "contact", "force", "error", "arc length", "error", "residuals",
           "made or broken", "force under friction", "arc length under it"},
          {});
  for (std::size_t i = 0; i < estimate.frames.size(); ++i) {
    const EstimatedFrame& frame = estimate.frames[i];
    const bool changes = i > 0 && (!frame.made.empty() || !frame.broken.empty());
    if (i % step != 0 && !changes && frame.status == EstimateStatus::solved) continue;
    std::string change;
    for (const int c : frame.made) change += fmt::format("{}{} made", change.empty() ? "" : ", ", c);
    for (const int c : frame.broken) change += fmt::format("{}{} broken", change.empty() ? "" : ", ", c);
    if (frame.status != EstimateStatus::solved)
      change += (change.empty() ? "" : ", ") + std::string(to_string(frame.status));
    const std::string rms = units.lengths(frame.residual_rms);
    if (frame.contacts.empty()) add_row({when(estimate, frame.time), "none", "", "", "", "", rms, change, "", ""}, {});
    for (std::size_t k = 0; k < frame.contacts.size(); ++k) {
      const EstimatedContact& c = frame.contacts[k].all;
      add_row({k == 0 ? when(estimate, frame.time) : "",
               std::to_string(frame.contacts[k].number) + (c.at_tip ? " (tip)" : ""), force(c.force),
               force(c.force_error), units.lengths(c.arc_length), units.lengths(c.arc_length_error), k == 0 ? rms : "",
               k == 0 ? change : "", "", ""},
              c.friction);
    }
  }
  const std::string some =
      step > 1 ? fmt::format("one frame in {}, and those with a change; all are in the JSON\n", step) : "";
  return '\n' + grid.text("") + (rough ? "under friction: whatever it does, each frame's points alone\n" : "") + some;
}

}  // namespace

std::string sequence_json(const Scene& scene, const SequenceSpec& spec, const SequenceEstimate& estimate,
                          const RunInfo& run) {
  const bool any = !estimate.frames.empty();
  Json json;
  add_fit(json, scene, estimate, any ? spec.frames[estimate.frames.size() - 1].points : std::vector<MeasuredPoint>{},
          run);
  json["frames"] = Json::array();
  for (const EstimatedFrame& frame : estimate.frames) json["frames"].push_back(frame_json(frame, estimate.timed));
  json["rates"] = {{"force", number(estimate.force_rate)},
                   {"place", number(estimate.place_rate)},
                   {"estimated", estimate.rates_estimated}};
  // As a single shape has them, of the last frame.
  json["moments"] = any ? json["frames"].back()["moments"] : Json::array();
  json["contacts"] = any ? json["frames"].back()["contacts"] : Json::array();
  return written(json);
}

std::string sequence_report(const Scene& scene, const SequenceEstimate& estimate) {
  const DisplayUnits units(scene);
  std::string text = fit_heading(scene, estimate) + note_lines(estimate.notes);
  if (!estimate.frames.empty()) {
    text +=
        line("frames", fmt::format("{}, from {} to {}, residuals {} (rms of a coordinate)", estimate.frames.size(),
                                   when(estimate, estimate.frames.front().time),
                                   when(estimate, estimate.frames.back().time), units.lengths(estimate.residual_rms)));
    text += noise_line(estimate, units);
    text +=
        line("rates", fmt::format("force {}, place {} {}{}", force(estimate.force_rate),
                                  units.lengths(estimate.place_rate), estimate.timed ? "in 1 s" : "from frame to frame",
                                  estimate.rates_estimated ? " (the largest that the frames allow)" : ""));
    text += fit_lines(estimate, units);
    text += contacts_text(estimate, units) + frames_text(estimate, units);
  }
  return text + fit_end(estimate);
}

}  // namespace tendril::app
