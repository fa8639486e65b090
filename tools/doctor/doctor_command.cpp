// SPDX-License-Identifier: BSD-3-Clause
#include "tools/doctor/doctor_command.h"

#include <cmath>
#include <exception>
#include <iterator>
#include <memory>

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "core/bus/channels.h"
#include "core/bus/options.h"
#include "core/config/config.h"
#include "core/files/mapped_file.h"
#include "core/process/process_arguments.h"
#include "core/process/process_usage.h"
#include "plslam_version.h"
#include "tools/doctor/host_checks.h"
#include "tools/doctor/multicast_check.h"
#include "tools/doctor/node/listen_node.h"
#include "tools/doctor/socket_check.h"

namespace plslam::doctor {
namespace {

struct DoctorOptions {
  bus::ProcessArguments common;
  std::string out = "out";
  double listen_s = 2.5;
  bool quiet = false;
  bool json = false;
};

/// The vocabularies that the configuration names; the other options of the section are loop_process's business.
struct VocabularyNames {
  std::string points = "orb.vocabulary";
  std::string lines = "lbd.vocabulary";
};

template <class Visitor>
void VisitFields(Visitor& visit, VocabularyNames& o) {
  visit("points", o.points, "vocabulary of points");
  visit("lines", o.lines, "vocabulary of lines");
}

void Append(Findings more, Findings* findings) {
  findings->insert(findings->end(), std::make_move_iterator(more.begin()), std::make_move_iterator(more.end()));
}

Findings CheckNetwork(const BusAddress& address) {
  Findings findings;
  if (address.kind == BusAddress::Kind::kMulticast) {
    Append(CheckMulticast(address), &findings);
    Append(CheckReceiveBuffer(address), &findings);
  }
  if (address.kind != BusAddress::Kind::kOther) Append(CheckPort(address), &findings);
  return findings;
}

Findings CheckFiles(const DoctorOptions& options, const Config& config, const bus::BusOptions& bus_options) {
  Findings findings = CheckPrograms();
  Append(CheckFolder(TemporaryRoot(), bus_options.history_dir.empty() ? "histories and features" : "features",
                     "export TMPDIR=FOLDER   # with space, for every process"),
         &findings);
  if (!bus_options.history_dir.empty())
    Append(CheckFolder(bus_options.history_dir, "histories", "--set bus.history_dir=FOLDER   # with space"),
           &findings);
  Append(CheckFolder(options.out, "outputs", "plslam run DATASET --out FOLDER   # with space"), &findings);
  VocabularyNames names;
  config.Read("loop.vocabularies", names);
  Append(CheckVocabulary(names.points, "points", "loop.vocabularies.points"), &findings);
  Append(CheckVocabulary(names.lines, "lines", "loop.vocabularies.lines"), &findings);
  return findings;
}

struct Diagnosis {
  Findings findings;
  Heard heard;
};

/// Listening needs a network that works.
Diagnosis Examine(const DoctorOptions& options) {
  bus::BusOptions bus_options;
  const Config config = options.common.MakeConfig();
  config.Read(kBusSection, bus_options);
  const BusAddress address = ParseBusAddress(bus_options.url);
  Diagnosis diagnosis;
  diagnosis.findings = CheckNetwork(address);
  const bool can_listen = !HasProblem(diagnosis.findings) && options.listen_s > 0.0;
  const ClockSample begin = SampleClocks();
  if (can_listen) {
    diagnosis.heard = ListenToAll(address.url, bus_options.key_file,
                                  std::chrono::milliseconds(std::llround(1e3 * options.listen_s)));
    Append(CheckProcesses(diagnosis.heard, {address.url, bus_options.prefix, PLSLAM_VERSION, bus::HostName(),
                                            bus::kSchemaVersion, !bus_options.key_file.empty()}),
           &diagnosis.findings);
  }
  Append(CheckClock(begin, SampleClocks(), ClockIsSynchronised()), &diagnosis.findings);
  Append(CheckFiles(options, config, bus_options), &diagnosis.findings);
  return diagnosis;
}

nlohmann::ordered_json ToJson(const Diagnosis& diagnosis) {
  nlohmann::ordered_json json = {{"healthy", !HasProblem(diagnosis.findings)}};
  json["findings"] = nlohmann::ordered_json::array();
  for (const Finding& f : diagnosis.findings) {
    json["findings"].push_back(
        {{"check", f.check}, {"verdict", VerdictName(f.verdict)}, {"what", f.what}, {"mend", f.mend}});
  }
  json["processes"] = nlohmann::ordered_json::array();
  for (const HeardProcess& p : diagnosis.heard.processes) {
    json["processes"].push_back({{"prefix", p.prefix},
                                 {"process", p.process},
                                 {"host", p.host},
                                 {"pid", p.pid},
                                 {"version", p.version},
                                 {"state", p.state},
                                 {"reason", p.reason}});
  }
  return json;
}

int Doctor(const DoctorOptions& options) {
  const Diagnosis diagnosis = Examine(options);
  if (options.json) {
    fmt::print("{}\n", ToJson(diagnosis).dump(2, ' ', false, nlohmann::json::error_handler_t::replace));
  } else {
    fmt::print("{}", FindingsToText(diagnosis.findings, options.quiet));
  }
  return HasProblem(diagnosis.findings) ? 1 : 0;
}

}  // namespace

void AddDoctorCommand(CLI::App* app, std::function<int()>* command) {
  auto options = std::make_shared<DoctorOptions>();
  auto* sub = app->add_subcommand("doctor", "finds what is wrong on this host, with the commands that repair it");
  options->common.AddTo(sub);
  sub->add_option("--out", options->out, "folder of the outputs")->type_name("DIR")->capture_default_str();
  sub->add_option("--listen", options->listen_s, "how long to listen to other processes, in seconds; 0: not at all")
      ->check(CLI::Range(0.0, 3600.0))
      ->capture_default_str();
  sub->add_flag("--quiet", options->quiet, "only problems and advice");
  sub->add_flag("--json", options->json, "findings and processes as JSON");
  sub->footer(
      "Checks multicast, receive buffers, ports, the clock, free space and vocabularies, and the versions, keys,\n"
      "prefixes and error reports of the processes on the bus.\n"
      "Examples:\n"
      "  plslam doctor\n"
      "  plslam doctor --config config/plslam.yaml --url udpm://239.255.76.67:7667?ttl=1\n"
      "  plslam doctor --url tcpq://192.0.2.7:7700 --json\n"
      "Exit code 0 if nothing prevents the system from working, else 1.");
  sub->callback([=] { *command = [options] { return Doctor(*options); }; });
}

}  // namespace plslam::doctor
