#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <set>

#include "figure/drawing.hpp"
#include "figure/movie.hpp"
#include "figure/picture.hpp"
#include "study/case.hpp"
#include "study/journal.hpp"
#include "study/result.hpp"
#include "study/worker_pool.hpp"
#include "system/output.hpp"
#include "system/progress.hpp"
#include "tendril/app/input_error.hpp"
#include "tendril/app/interrupt.hpp"
#include "tendril/app/study_command.hpp"
#include "tendril/grasp.hpp"
#include "tendril/version.hpp"

namespace tendril::app {

namespace {

namespace fs = std::filesystem;

struct Shard {
  int number = 1;
  int count = 1;
  bool holds(int index) const { return index % count == number - 1; }
};

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

/// Everything that the numbers depend on and a user can change.
std::uint64_t fingerprint_of(const SceneArguments& arguments) {
  std::string text = std::string(TENDRIL_VERSION) + '\0' + read_scene_input(arguments.scene);
  for (const Override& setting : arguments.overrides) text += '\0' + setting.key + '=' + setting.text;
  return checksum(text);
}

std::string greeting_of(std::uint64_t fingerprint) { return fmt::format("tendril worker {:016x}", fingerprint); }

int serve(const StudyArguments& arguments) {
  const std::uint64_t fingerprint = fingerprint_of(arguments.scene);
  Session session(arguments.scene);
  const Scene scene = session.scene();
  const StudySpec study = session.study();
  const std::vector<StudyCase> cases = study_cases(study);
  return serve_pool(greeting_of(fingerprint), [&](int index) {
    const auto begin = std::chrono::steady_clock::now();
    StudyRecord record;
    record.index = index;
    record.payload = run_case(session, scene, study, cases.at(static_cast<std::size_t>(index)));
    record.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    std::string line = record_line(record);
    line.pop_back();
    return line;
  });
}

/// Cases that no scene could hold are better found before any worker starts.
void check_cases(Session& session, const Scene& scene, const StudySpec& study, const std::vector<StudyCase>& cases) {
  if (scene.problem == ProblemKind::trajectory && !study.targets.empty()) {
    throw InputError(scene.file + ": [study] has targets beside a trajectory, expected modes or limits only");
  }
  const bool changes = !study.moments.empty() || !study.pressures.empty();
  const bool of_grasps = !study.diameters.empty() || changes || !study.force_limits.empty();
  if (of_grasps && scene.problem != ProblemKind::grasp) {
    throw InputError(scene.file +
                     ": [study] has diameters, force_limits or moments, expected a scene with problem = \"grasp\"");
  }
  if (scene.problem == ProblemKind::grasp && (!study.targets.empty() || !study.modes.empty())) {
    throw InputError(scene.file +
                     ": [study] has targets or modes, expected diameters, force_limits, limits or moments "
                     "for a grasp");
  }
  if (changes && plans_both_fingers(scene)) {
    throw InputError(
        scene.file +
        ": [study] has moments or pressures, which change one of mirrored fingers, but both fingers of this scene "
        "are planned; expected diameters, force_limits or limits");
  }
  std::set<std::optional<StudyMode>> seen;
  for (const StudyCase& one : cases) {
    if (!seen.insert(one.mode).second) continue;
    session.use(scene_of(scene, one));
    session.problem();
  }
  session.use(scene);
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

/// Final files, table and exit code of a study of which every case is known.
int finish(Session& session, const StudyArguments& arguments, const StudySpec& study,
           const std::map<int, StudyRecord>& records) {
  const StudyResult result = study_result(study, records);
  const Scene& scene = session.scene();
  const std::string json = study_json(scene, result);
  const std::string report = study_report(scene, result);
  std::optional<Json> drawing;
  if (arguments.output || arguments.figure || arguments.movie)
    drawing = drawing_of(Json::parse(json), "the study", session.registry());
  if (arguments.output) {
    {
      StagedFiles files(*arguments.output);
      files.write("study.json", json);
      files.write("cases.csv", cases_csv(result));
      files.write("groups.csv", groups_csv(result));
      files.write("table.txt", report);
      files.write("times.csv", times_csv(result));
      files.publish();
    }
    // Results without their picture are still results.
    try {
      StagedFiles files(*arguments.output);
      draw_study(scene, result, *drawing, files, "figure", {Picture::svg, Picture::png});
      files.publish();
    } catch (const InputError& error) {
      note(error.what());
    }
  }
  if (arguments.figure && picture_of(*arguments.figure) != Picture::page) {
    StagedFiles files(arguments.figure->parent_path());
    draw_study(scene, result, *drawing, files, arguments.figure->stem().string(), {picture_of(*arguments.figure)});
    files.publish();
  } else if (arguments.figure) {
    require_shape(*drawing);
    write_picture(*arguments.figure, *drawing);
  }
  if (arguments.movie) {
    require_shape(*drawing);
    write_movie(*arguments.movie, *drawing);
  }
  print(arguments.json ? json : report);
  return all_solved(result) ? 0 : 1;
}

/// Which part of the cases is asked for. What cannot be written had better be known before the work begins.
Shard checked(const StudyArguments& arguments) {
  const std::optional<Shard> shard = arguments.shard.empty() ? Shard{} : parse_shard(arguments.shard);
  if (!shard) {
    throw InputError(
        fmt::format("--shard {}: expected i/N with 1 <= i <= N <= {}, for instance 2/4", arguments.shard, most_shards));
  }
  if (!arguments.output && (arguments.merge || !arguments.shard.empty())) {
    throw InputError("--shard and --merge need --output DIR, where the shards are");
  }
  if (arguments.merge && !arguments.shard.empty()) {
    throw InputError("--merge joins all shards, expected no --shard beside it");
  }
  if (arguments.figure) {
    picture_of(*arguments.figure);
    const StagedFiles trial(arguments.figure->parent_path());
  }
  if (arguments.movie) {
    require_movie(*arguments.movie);
    const StagedFiles trial(arguments.movie->parent_path());
  }
  return *shard;
}

}  // namespace

int run_study(const StudyArguments& arguments) {
  if (arguments.worker) return serve(arguments);
  const Shard shard = checked(arguments);
  if (arguments.scene.scene == standard_input) share_standard_input();
  const std::uint64_t fingerprint = fingerprint_of(arguments.scene);
  Session session(arguments.scene);
  const Scene scene = session.scene();
  for (const std::string& warning : scene.warnings) note(warning);
  const StudySpec study = session.study();
  const std::vector<StudyCase> cases = study_cases(study);
  check_cases(session, scene, study, cases);
  const auto case_count = static_cast<int>(cases.size());
  if (arguments.merge) return finish(session, arguments, study, merged(*arguments.output, fingerprint, case_count));

  std::optional<Journal> journal;
  if (arguments.output) {
    journal.emplace(*arguments.output / journal_name(shard.number, shard.count),
                    JournalHeader{fingerprint, shard.number, shard.count, case_count});
  }
  std::map<int, StudyRecord> records = journal ? journal->records() : std::map<int, StudyRecord>{};
  PoolTasks tasks;
  tasks.arguments = arguments.words;
  tasks.arguments.push_back("--worker");
  tasks.greeting = greeting_of(fingerprint);
  for (const StudyCase& one : cases) {
    if (shard.holds(one.index) && !records.contains(one.index)) tasks.cases.push_back(one.index);
  }
  const std::size_t mine = tasks.cases.size() + records.size();
  if (!records.empty() && !tasks.cases.empty()) {
    note(fmt::format("{} of {} cases are there already; {} to go", records.size(), mine, tasks.cases.size()));
  }
  tasks.jobs = std::min(arguments.jobs, std::max(1, static_cast<int>(tasks.cases.size())));
  const InterruptGuard interrupt;
  tasks.stop = &InterruptGuard::flag();
  bool finished = true;
  {
    Progress progress("study", "cases", mine, records.size());
    const auto keep = [&](StudyRecord record, bool failed) {
      if (journal) journal->append(record);
      const int index = record.index;
      records.emplace(index, std::move(record));
      progress.step(failed);
    };
    tasks.on_answer = [&](int index, const std::string& line) {
      std::optional<StudyRecord> record = parse_record(line);
      if (!record || record->index != index) {
        throw InputError(fmt::format("a worker answered case {} with something else", index));
      }
      keep(std::move(*record), false);
    };
    tasks.on_crash = [&](int index, const std::string& reason) {
      keep({index, 0.0, failed_case(cases[static_cast<std::size_t>(index)], reason)}, true);
    };
    finished = run_pool(tasks);
  }
  if (!finished) {
    note(fmt::format("interrupted: {} of {} cases are finished{}", records.size(), mine,
                     journal ? "; run the same command again to go on" : ""));
    return 1;
  }
  if (shard.count == 1) return finish(session, arguments, study, records);
  note(fmt::format("shard {} of {}: {} cases are finished; --merge joins the shards", shard.number, shard.count,
                   records.size()));
  return 0;
}

}  // namespace tendril::app
