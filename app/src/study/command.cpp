#include <fmt/format.h>

#include <algorithm>

#include "study/run.hpp"
#include "study/worker_pool.hpp"
#include "system/output.hpp"
#include "system/progress.hpp"
#include "tendril/app/files.hpp"
#include "tendril/app/interrupt.hpp"

namespace tendril::app {

namespace {

std::string greeting_of(const StudyCases& cases) { return fmt::format("tendril worker {:016x}", cases.fingerprint()); }

int serve(const StudyArguments& arguments) {
  StudyCases cases(arguments.scene);
  return serve_pool(greeting_of(cases), [&](int index) { return cases.answer(index); });
}

int finish(StudyRun& run, bool json) {
  const StudyRun::Finished finished = run.finish();
  for (const std::string& text : finished.notes) note(text);
  print(json ? finished.json : finished.report);
  return finished.solved ? 0 : 1;
}

}  // namespace

int run_study(const StudyArguments& arguments) {
  if (arguments.worker) return serve(arguments);
  if (arguments.scene.scene == standard_input) share_standard_input();
  StudyRun run(arguments.scene, arguments.places);
  for (const std::string& warning : run.cases().scene().warnings) note(warning);
  if (arguments.places.merge) return finish(run, arguments.json);

  PoolTasks tasks;
  tasks.arguments = arguments.words;
  tasks.arguments.push_back("--worker");
  tasks.greeting = greeting_of(run.cases());
  tasks.cases = run.waiting();
  const std::size_t mine = tasks.cases.size() + run.finished();
  if (run.finished() > 0 && !tasks.cases.empty()) {
    note(fmt::format("{} of {} cases are there already; {} to go", run.finished(), mine, tasks.cases.size()));
  }
  tasks.jobs = std::min(arguments.jobs, std::max(1, static_cast<int>(tasks.cases.size())));
  const InterruptGuard interrupt;
  tasks.stop = &InterruptGuard::flag();
  bool finished = true;
  {
    Progress progress("study", "cases", mine, run.finished());
    tasks.on_answer = [&](int index, const std::string& line) {
      run.take(index, line);
      progress.step(false);
    };
    tasks.on_crash = [&](int index, const std::string& reason) {
      run.lost(index, reason);
      progress.step(true);
    };
    finished = run_pool(tasks);
  }
  if (!finished) {
    note(fmt::format("interrupted: {} of {} cases are finished{}", run.finished(), mine,
                     arguments.places.output ? "; run the same command again to go on" : ""));
    return 1;
  }
  if (run.shard().count == 1) return finish(run, arguments.json);
  note(fmt::format("shard {} of {}: {} cases are finished; --merge joins the shards", run.shard().number,
                   run.shard().count, run.finished()));
  return 0;
}

}  // namespace tendril::app
