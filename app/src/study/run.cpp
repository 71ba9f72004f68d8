#include "study/run.hpp"

#include <fmt/format.h>

#include <charconv>
#include <chrono>
#include <set>
#include <utility>

#include "figure/drawing.hpp"
#include "figure/movie.hpp"
#include "figure/picture.hpp"
#include "study/case.hpp"
#include "study/result.hpp"
#include "tendril/app/input_error.hpp"
#include "tendril/grasp.hpp"
#include "tendril/version.hpp"

namespace tendril::app {

namespace {

namespace fs = std::filesystem;

constexpr int most_shards = 10000;

std::optional<Shard> parse_shard(std::string_view text) {
  Shard shard;
  const char* end = text.data() + text.size();
  const auto first = std::from_chars(text.data(), end, shard.number);
  if (first.ec != std::errc{} || first.ptr == end || *first.ptr != '/') return std::nullopt;
  const auto second = std::from_chars(first.ptr + 1, end, shard.count);
  const bool good = second.ec == std::errc{} && second.ptr == end && shard.number >= 1 && shard.number <= shard.count &&
                    shard.count <= most_shards;
  return good ? std::optional(shard) : std::nullopt;
}

std::uint64_t fingerprint_of(const SceneArguments& arguments) {
  std::string text =
      std::string(TENDRIL_VERSION) + '\0' + (arguments.text ? *arguments.text : read_scene_input(arguments.scene));
  for (const Override& setting : arguments.overrides) text += '\0' + setting.key + '=' + setting.text;
  return checksum(text);
}

/// The results of every shard, or an InputError that names each one that is missing, torn or incomplete.
std::map<int, StudyRecord> merged(const fs::path& directory, std::uint64_t fingerprint, int cases) {
  std::set<int> counts;
  std::error_code error;
  for (const auto& file : fs::directory_iterator(directory, error)) {
    const std::string name = file.path().filename().string();
    const std::size_t middle = name.find("-of-");
    if (!name.starts_with("shard-") || !name.ends_with(".journal") || middle == std::string::npos) continue;
    const std::string number = name.substr(6, middle - 6);
    const std::string count = name.substr(middle + 4, name.size() - middle - 4 - std::string(".journal").size());
    if (const std::optional<Shard> shard = parse_shard(number + '/' + count)) counts.insert(shard->count);
  }
  if (error) throw InputError("--merge: cannot read '" + directory.string() + "': " + error.message());
  if (counts.empty()) {
    throw InputError("--merge: found no shard in '" + directory.string() + "', expected files such as " +
                     journal_name(1, 4));
  }
  if (counts.size() > 1) {
    std::string found;
    for (const int count : counts) found += fmt::format("{}{}", found.empty() ? "" : " and of ", count);
    throw InputError("--merge: found shards of " + found + " in '" + directory.string() +
                     "', expected those of one division only");
  }
  const int count = *counts.begin();
  std::map<int, StudyRecord> records;
  std::string trouble;
  for (int i = 1; i <= count; ++i) {
    const Shard shard{i, count};
    const std::string name = journal_name(i, count);
    JournalContents contents = read_journal(directory / name);
    const std::string expected = JournalHeader{fingerprint, i, count, cases}.line();
    std::vector<int> missing;
    for (int index = 0; index < cases; ++index) {
      if (shard.holds(index) && !contents.records.contains(index)) missing.push_back(index);
    }
    const std::string intro = fmt::format("\n  shard {} of {}: ", i, count);
    if (!contents.exists) {
      trouble += intro + "'" + name + "' is missing";
    } else if (contents.header.empty() || (contents.torn && !missing.empty())) {
      trouble += intro + "'" + name + "' is torn: its last line is cut off";
    } else if (contents.header != expected) {
      trouble += intro + "'" + name + "' belongs to another study (" + contents.header + ")";
    } else if (!missing.empty()) {
      trouble += intro + fmt::format("'{}' is not complete: {} cases are missing, the first is number {}{}", name,
                                     missing.size(), missing.front(),
                                     contents.damaged_lines > 0 ? ", and it has damaged lines" : "");
    }
    records.merge(contents.records);
  }
  if (!trouble.empty()) {
    throw InputError("--merge: not every shard in '" + directory.string() + "' is complete:" + trouble +
                     "\nrun 'tendril study SCENE --output DIR --shard i/N' for those");
  }
  return records;
}

void require_shape(const Json& drawing) {
  if (!has_shape(drawing)) throw InputError("no figure: the study holds no shape");
}

/// Which part of the cases is asked for. What cannot be written had better be known before the work begins.
Shard checked(const StudyPlaces& places) {
  const std::optional<Shard> shard = places.shard.empty() ? Shard{} : parse_shard(places.shard);
  if (!shard) {
    throw InputError(
        fmt::format("--shard {}: expected i/N with 1 <= i <= N <= {}, for instance 2/4", places.shard, most_shards));
  }
  if (!places.output && (places.merge || !places.shard.empty())) {
    throw InputError("--shard and --merge need --output DIR, where the shards are");
  }
  if (places.merge && !places.shard.empty()) {
    throw InputError("--merge joins all shards, expected no --shard beside it");
  }
  if (places.figure) {
    picture_of(*places.figure);
    const StagedFiles trial(places.figure->parent_path());
  }
  if (places.movie) {
    require_movie(*places.movie);
    const StagedFiles trial(places.movie->parent_path());
  }
  return *shard;
}

}  // namespace

StudyCases::StudyCases(const SceneArguments& arguments)
    : fingerprint_(fingerprint_of(arguments)),
      session_(arguments),
      scene_(session_.scene()),
      study_(session_.study()),
      cases_(study_cases(study_)) {}

void StudyCases::check() {
  if (scene_.problem == ProblemKind::trajectory && !study_.targets.empty()) {
    throw InputError(scene_.file + ": [study] has targets beside a trajectory, expected modes or limits only");
  }
  const bool places = !study_.insertions.empty() || !study_.base_positions.empty() || !study_.base_angles.empty();
  if (places && scene_.problem == ProblemKind::grasp) {
    throw InputError(scene_.file + ": [study] has places of a rod, but the fingers of a grasp stand on the palm");
  }
  const bool changes = !study_.moments.empty() || !study_.pressures.empty();
  const bool of_grasps = !study_.diameters.empty() || changes || !study_.force_limits.empty();
  if (of_grasps && scene_.problem != ProblemKind::grasp) {
    throw InputError(scene_.file +
                     ": [study] has diameters, force_limits or moments, expected a scene with problem = \"grasp\"");
  }
  if (scene_.problem == ProblemKind::grasp && (!study_.targets.empty() || !study_.modes.empty())) {
    throw InputError(scene_.file +
                     ": [study] has targets or modes, expected diameters, force_limits, limits or moments "
                     "for a grasp");
  }
  if (changes && plans_both_fingers(scene_)) {
    throw InputError(
        scene_.file +
        ": [study] has moments or pressures, which change one of mirrored fingers, but both fingers of this scene "
        "are planned; expected diameters, force_limits or limits");
  }
  std::set<std::pair<std::optional<StudyMode>, std::optional<double>>> seen;
  for (const StudyCase& one : cases_) {
    if (!seen.insert({one.mode, one.insertion}).second) continue;
    session_.use(scene_of(scene_, one));
    session_.problem();
  }
  session_.use(scene_);
}

std::string StudyCases::answer(int index) {
  const auto begin = std::chrono::steady_clock::now();
  StudyRecord record;
  record.index = index;
  record.payload = run_case(session_, scene_, study_, cases_.at(static_cast<std::size_t>(index)));
  record.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  std::string line = record_line(record);
  line.pop_back();
  return line;
}

StudyRun::StudyRun(const SceneArguments& arguments, const StudyPlaces& places)
    : places_(places), shard_(checked(places)), cases_(arguments) {
  cases_.check();
  const auto count = static_cast<int>(cases_.all().size());
  if (places_.merge) {
    records_ = merged(*places_.output, cases_.fingerprint(), count);
  } else if (places_.output) {
    journal_.emplace(*places_.output / journal_name(shard_.number, shard_.count),
                     JournalHeader{cases_.fingerprint(), shard_.number, shard_.count, count});
    records_ = journal_->records();
  }
}

std::vector<int> StudyRun::waiting() const {
  std::vector<int> waiting;
  for (const StudyCase& one : cases_.all()) {
    if (shard_.holds(one.index) && !records_.contains(one.index)) waiting.push_back(one.index);
  }
  return waiting;
}

void StudyRun::take(int index, const std::string& answer) {
  std::optional<StudyRecord> record = parse_record(answer);
  if (!record || record->index != index) {
    throw InputError(fmt::format("a worker answered case {} with something else", index));
  }
  keep(std::move(*record));
}

void StudyRun::lost(int index, const std::string& reason) {
  keep({index, 0.0, failed_case(cases_.all().at(static_cast<std::size_t>(index)), reason)});
}

void StudyRun::keep(StudyRecord record) {
  if (journal_) journal_->append(record);
  const int index = record.index;
  records_.emplace(index, std::move(record));
}

StudyRun::Finished StudyRun::finish(const std::atomic<bool>* stop) {
  const StudyResult result = study_result(cases_.study(), records_);
  const Scene& scene = cases_.scene();
  Finished finished{study_json(scene, result), study_report(scene, result), all_solved(result), {}};
  std::optional<Json> drawing;
  if (places_.output || places_.figure || places_.movie)
    drawing = drawing_of(Json::parse(finished.json), "the study", cases_.session().registry());
  if (places_.output) {
    {
      StagedFiles files(*places_.output);
      files.write("study.json", finished.json);
      files.write("cases.csv", cases_csv(result));
      files.write("groups.csv", groups_csv(result));
      files.write("table.txt", finished.report);
      files.write("times.csv", times_csv(result));
      files.publish();
    }
    // Results without their picture are still results.
    try {
      StagedFiles files(*places_.output);
      draw_study(scene, result, *drawing, files, "figure", {Picture::svg, Picture::png});
      files.publish();
    } catch (const InputError& error) {
      finished.notes.emplace_back(error.what());
    }
  }
  if (places_.figure && picture_of(*places_.figure) != Picture::page) {
    StagedFiles files(places_.figure->parent_path());
    draw_study(scene, result, *drawing, files, places_.figure->stem().string(), {picture_of(*places_.figure)});
    files.publish();
  } else if (places_.figure) {
    require_shape(*drawing);
    write_picture(*places_.figure, *drawing, stop);
  }
  if (places_.movie) {
    require_shape(*drawing);
    write_movie(*places_.movie, *drawing, stop);
  }
  return finished;
}

}  // namespace tendril::app
