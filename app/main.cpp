#include "tendril/app/commands.hpp"
#include "tendril/plugins/crash.hpp"
#include "tendril/plugins/probe.hpp"

int main(int argc, char** argv) {
  if (const auto code = tendril::plugins::answer_probe(argc, argv)) return *code;
  tendril::plugins::name_plugin_in_crashes();
  return tendril::app::run_command_line(argc, argv);
}
