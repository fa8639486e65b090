// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gmock/gmock.h>

#include <chrono>
#include <fstream>
#include <nlohmann/json.hpp>
#include <random>
#include <thread>

#include "core/bus/bus.h"
#include "core/bus/channels.h"
#include "core/io/files/atomic_file.h"
#include "core/io/maps/map_camera.h"
#include "core/io/trajectories/pose_covariance.h"
#include "core/io/trajectories/trajectory.h"
#include "plslam/pose_t.hpp"
#include "plslam/status_t.hpp"
#include "tests/support/data_folder.h"
#include "tests/support/python.h"
#include "tests/support/sanitized.h"
#include "tests/support/shell.h"
#include "tests/unit/map_file/stored_maps.h"

namespace plslam::test {
namespace {

using nlohmann::json;
using testing::HasSubstr;

/// The built package, called by short programs.
class Python : public testing::Test {
 protected:
  void SetUp() override {
    python_ = PythonWithNumpy();
    if (python_.empty()) GTEST_SKIP() << "no Python with numpy here";
  }

  ShellResult Run(const std::string& program, const std::string& arguments = "") const {
    folder_.Write("program.py", "import json, sys\nimport numpy as np\nimport plslam\n" + program);
    return Shell(folder_, fmt::format("cd '{}' && PYTHONDONTWRITEBYTECODE=1 PYTHONPATH='{}' {} program.py {}",
                                      folder_.Path(""), PLSLAM_PYTHON_FOLDER, python_, arguments));
  }

  /// Returns the output of the program, parsed as JSON.
  json Answer(const std::string& program) const {
    const ShellResult result = Run(program);
    EXPECT_EQ(result.exit_code, 0) << result.error;
    return json::parse(result.out, nullptr, false);
  }

  const ScratchFolder& folder() const { return folder_; }

 private:
  ScratchFolder folder_;
  std::string python_;
};

template <class Matrix>
std::vector<double> Numbers(const Matrix& matrix) {
  return {matrix.data(), matrix.data() + matrix.size()};
}

/// Row by row, as numpy lists a matrix.
std::vector<double> Rows(const Eigen::Matrix4d& matrix) {
  const Eigen::Matrix4d transposed = matrix.transpose();
  return Numbers(transposed);
}

Eigen::Matrix4d MatrixOf(const SE3& T) {
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  matrix.topLeftCorner<3, 3>() = T.rotation().toRotationMatrix();
  matrix.topRightCorner<3, 1>() = T.translation();
  return matrix;
}

void ExpectNear(const std::vector<double>& read, const std::vector<double>& written, double tolerance) {
  ASSERT_EQ(read.size(), written.size());
  for (size_t i = 0; i < read.size(); ++i) EXPECT_NEAR(read[i], written[i], tolerance) << i;
}

TEST_F(Python, MapEqualsTheWrittenOne) {
  StoredMap stored = test::OfTwoCameras(7, 600);
  stored.rig = CameraBytes({420.5, 375.25, 239.75, 0.11, 752, 480});
  WriteMapFile(folder().Path("map.plmap"), stored);
  const json map = Answer(R"(
m = plslam.load_map("map.plmap")
k, p, l = m.keyframes, m.points, m.lines
def observations(of, i):
    rows = of.observations[of.observations["row"] == i]
    return [[int(r["keyframe_id"]), int(r["feature"])] for r in rows]
print(json.dumps({
  "version": m.version, "camera": vars(m.camera), "ids": k.id.tolist(), "t_ns": k.t_ns.tolist(), "parents": k.parent_id.tolist(),
  "T_w_kf": k.T_w_kf.reshape(len(k.id), 16).tolist(), "covariance": k.covariance.reshape(len(k.id), 36).tolist(),
  "points": [{"id": int(p.id[i]), "p_w": p.p_w[i].tolist(), "descriptor": p.descriptor[i].tobytes().hex(),
              "observations": observations(p, i)} for i in range(len(p.id))],
  "lines": [{"id": int(l.id[i]), "p_w": l.p_w[i].tolist(), "q_w": l.q_w[i].tolist(), "observations": observations(l, i)}
            for i in range(len(l.id))],
  "features": {str(i): [f.points["px"].tolist(), f.lines["q_px"].tolist(), f.points["disparity_px"].tolist(), f.image]
               for i, f in m.features.items()},
  "loops": m.loops["keyframe_id"].tolist()}))
)");
  ASSERT_TRUE(map.is_object());
  EXPECT_EQ(map["version"], stored.version);
  EXPECT_EQ(map["camera"]["f_px"], 420.5);
  EXPECT_EQ(map["camera"]["height_px"], 480);
  ASSERT_EQ(map["ids"].size(), stored.map.keyframes().size());
  ASSERT_GT(map["ids"].size(), 3U);
  size_t i = 0;
  for (const auto& [id, keyframe] : stored.map.keyframes()) {
    EXPECT_EQ(map["ids"][i], id.value);
    EXPECT_EQ(map["t_ns"][i], keyframe.t_ns);
    EXPECT_EQ(map["parents"][i], keyframe.parent_id.value);
    ExpectNear(map["T_w_kf"][i], Rows(MatrixOf(keyframe.T_w_kf)), 1e-12);
    ExpectNear(map["covariance"][i], Numbers(keyframe.covariance), 0.0);
    ++i;
  }
  ASSERT_EQ(map["points"].size(), stored.map.points().size());
  i = 0;
  for (const auto& [id, point] : stored.map.points()) {
    const json& read = map["points"][i++];
    EXPECT_EQ(read["id"], id.value);
    ExpectNear(read["p_w"], Numbers(point.p_w), 0.0);
    const auto* bytes = reinterpret_cast<const uint8_t*>(point.descriptor.data());
    EXPECT_EQ(read["descriptor"], fmt::format("{:02x}", fmt::join(bytes, bytes + 32, "")));
    ASSERT_EQ(read["observations"].size(), point.observations.size());
    for (size_t k = 0; k < point.observations.size(); ++k) {
      EXPECT_EQ(read["observations"][k][0], point.observations[k].keyframe_id().value);
      EXPECT_EQ(read["observations"][k][1], point.observations[k].feature);
    }
  }
  ASSERT_EQ(map["lines"].size(), stored.map.lines().size());
  i = 0;
  for (const auto& [id, line] : stored.map.lines()) {
    const json& read = map["lines"][i++];
    ExpectNear(read["p_w"], Numbers(line.segment_w.p), 0.0);
    ExpectNear(read["q_w"], Numbers(line.segment_w.q), 0.0);
    EXPECT_EQ(read["observations"].size(), line.observations.size());
  }
  for (const auto& [id, features] : stored.features) {
    const json& read = map["features"][std::to_string(id.value)];
    ASSERT_EQ(read[0].size(), features.points.size());
    ASSERT_EQ(read[1].size(), features.lines.size());
    ASSERT_EQ(read[3].is_null(), !features.image);
    if (features.image) {
      EXPECT_EQ(read[3], json::array({-40, 3, features.image->width_px, 500, 320.5}));
    }
    for (size_t k = 0; k < features.points.size(); ++k) {
      ExpectNear(read[0][k], Numbers(features.points[k].left.px), 0.0);
      EXPECT_EQ(read[2][k], features.points[k].disparity_px);
    }
  }
  EXPECT_EQ(map["loops"].size(), stored.map.loops().size());
}

TEST_F(Python, ADamagedMapRaisesOneSentence) {
  StoredMap stored = RandomStoredMap(8, 200);
  stored.rig = CameraBytes({420.5, 375.25, 239.75, 0.11, 752, 480});
  std::vector<uint8_t> bytes = EncodeMap(stored);
  const auto write = [&](const std::string& name) {
    std::ofstream(folder().Path(name), std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  };
  write("map.plmap");
  // A count that is too large for any file, with a valid checksum: only the check of the content can detect it.
  std::fill(bytes.begin() + 56 + 8 + 8 + 48 + 40, bytes.begin() + 56 + 8 + 8 + 48 + 48, 0x7f);
  Sign(bytes);
  write("count.plmap");
  const json said = Answer(R"(
data = open("map.plmap", "rb").read()
def why(content):
    open("bad.plmap", "wb").write(content)
    try:
        plslam.load_map("bad.plmap")
    except plslam.FileError as error:
        return str(error)
    return "taken"
flipped = {why(data[:i] + bytes([data[i] ^ 1]) + data[i + 1:]) for i in range(0, len(data), max(1, len(data) // 300))}
cut = {why(data[:n]).split(" bytes")[0].split(" has ")[0] for n in range(0, len(data), max(1, len(data) // 100))}
newer = why(data[:8] + bytes([3]) + data[9:])
try:
    count = plslam.load_map("count.plmap") and "taken"
except plslam.FileError as error:
    count = str(error)
print(json.dumps({"flipped": sorted(flipped), "cut": sorted(cut), "format": newer, "count": count}))
)");
  ASSERT_TRUE(said.is_object());
  for (const char* kind : {"flipped", "cut"}) {
    for (const json& sentence : said[kind])
      EXPECT_THAT(sentence.get<std::string>(), testing::StartsWith("bad.plmap"));
    EXPECT_THAT(said[kind].dump(), testing::Not(HasSubstr("taken")));
  }
  EXPECT_THAT(said["format"].get<std::string>(), HasSubstr("of format 3, but this package reads formats 1 to 2"));
  EXPECT_THAT(said["count"].get<std::string>(), HasSubstr("is shorter than it states"));
}

/// Publishes poses 0 .. n - 1, identified by their numbers.
pose_t PoseNumber(int i) {
  pose_t pose{};
  pose.header.t_ns = 1'700'000'000'123'456'789 + i;
  pose.frame_id = i;
  pose.T_odom_c.position_m[2] = 0.25 * i;
  pose.T_odom_c.q_wxyz[0] = 1.0;
  pose.T_w_odom.q_wxyz[0] = 1.0;
  pose.n_stages = 1;
  pose.stages.resize(1);
  pose.stages[0].name = "match";
  pose.stages[0].ms = i;
  return pose;
}

/// Any value of the content may be invalid in a file with a valid checksum.
TEST_F(Python, AMapThatIsWrongWithARightChecksumRaises) {
  StoredMap stored = OfTwoCameras(10, 60);
  stored.rig = CameraBytes({420.5, 375.25, 239.75, 0.11, 752, 480});
  const std::vector<uint8_t> bytes = EncodeMap(stored);
  std::ofstream(folder().Path("map.plmap"), std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const json said = Answer(R"(
import hashlib, random
data = open("map.plmap", "rb").read()
rng = random.Random(1)
sentences, taken = set(), 0
def load(content):
    global taken
    head = data[:24]
    digest = hashlib.blake2b(head + content, digest_size=32).digest()
    open("bad.plmap", "wb").write(head + digest + content)
    try:
        plslam.load_map("bad.plmap")
        taken += 1
    except plslam.FileError as error:
        sentences.add(str(error))
content = data[56:]
for _ in range(400):
    at = rng.randrange(len(content) // 8) * 8
    load(content[:at] + rng.randbytes(8) + content[at + 8:])
# The images of keyframes stand last: one of a keyframe that has no features.
load(content[:-32] + bytes([77]) * 8 + content[-24:])
print(json.dumps({"sentences": sorted(sentences), "taken": taken}))
)");
  ASSERT_TRUE(said.is_object());
  EXPECT_GT(said["taken"].get<int>(), 0) << "positions may be any numbers";
  for (const json& sentence : said["sentences"]) {
    EXPECT_THAT(sentence.get<std::string>(), testing::StartsWith("bad.plmap: "));
  }
  EXPECT_THAT(said["sentences"].dump(), HasSubstr("has no features"));
}

TEST_F(Python, LogIsReadUntilItsDamage) {
  {
    bus::BusOptions options;
    options.url = "file://" + folder().Path("log") + "?mode=w";
    options.prefix = "front/";
    bus::Bus bus(options, "vo");
    for (int i = 0; i < 20; ++i) bus.Publish(bus::kPose, PoseNumber(i));
    status_t status{};
    status.process = "vo";
    status.state = "running";
    bus.Publish(bus::kStatus, status);
  }
  const json read = Answer(R"(
def frames(path, **more):
    out, end = [], "end"
    try:
        for m in plslam.read_log(path, **more):
            if m.channel == "POSE":
                v = m.value
                out.append([v.frame_id, v.header.t_ns, plslam.transform(v.T_odom_c)[2, 3], v.stages[0].name])
            elif m.channel == "STATUS":
                out.append([m.value.process, m.value.state])
    except plslam.FileError as error:
        end = str(error)
    return [out, end]
data = open("log", "rb").read()
open("cut", "wb").write(data[:-10])
open("nothing", "wb").close()
open("text", "w").write("hello\n")
open("head", "wb").write(data[:6])
open("broken", "wb").write(data[:2000].replace(b"\xed\xa1\xda\x01", b"\xed\xa1\xda\x02") + data[2000:])
middle = data.find(b"\xed\xa1\xda\x01", len(data) // 2)
open("middle", "wb").write(data[:middle] + b"xx" + data[middle:])
print(json.dumps({"whole": frames("log", prefix="front/"), "other": frames("log", prefix="rear/"), "none": frames("log"),
                  "status": frames("log", prefix="front/", channels=["STATUS"]), "cut": frames("cut", prefix="front/"),
                  "broken": frames("broken"), "small": [frames(name)[1] for name in ("nothing", "text", "head")], "middle": frames("middle", prefix="front/")}))
)");
  ASSERT_TRUE(read.is_object());
  ASSERT_EQ(read["whole"][0].size(), 21U) << read["whole"];
  EXPECT_EQ(read["whole"][1], "end");
  for (int i = 0; i < 20; ++i)
    EXPECT_EQ(read["whole"][0][i], json({i, 1'700'000'000'123'456'789 + i, 0.25 * i, "match"}));
  EXPECT_EQ(read["whole"][0][20], json({"vo", "running"}));
  EXPECT_EQ(read["other"], json({json::array(), "end"}));
  EXPECT_EQ(read["none"], json({json::array(), "end"}));
  EXPECT_EQ(read["status"][0], json::array({json({"vo", "running"})}));
  EXPECT_EQ(read["cut"][0].size(), 20U);
  EXPECT_THAT(read["cut"][1].get<std::string>(), HasSubstr("cut: is truncated within the event at byte "));
  EXPECT_EQ(read["small"], json({"nothing: is empty", "text: is not an LCM log: no event begins at byte 0",
                                 "head: is truncated at byte 0"}));
  EXPECT_EQ(read["broken"][1], "broken: is not an LCM log: no event begins at byte 0");
  EXPECT_GT(read["middle"][0].size(), 5U);
  EXPECT_THAT(read["middle"][1].get<std::string>(), HasSubstr("middle: is damaged: no event begins at byte "));
}

TEST_F(Python, MessagesOfAnotherVersionGiveOneWarning) {
  const std::string golden = (SourceFolder() / "tests/golden/0.2/room.lcm").string();
  const json read = Answer(fmt::format(R"(
import collections, warnings
with warnings.catch_warnings(record=True) as told:
    warnings.simplefilter("default")
    counts = collections.Counter(m.channel for m in plslam.read_log("{}"))
print(json.dumps({{"counts": counts, "told": [str(w.message) for w in told]}}))
)",
                                       golden));
  ASSERT_TRUE(read.is_object());
  EXPECT_GT(read["counts"]["STEREO_FRAME"], 10);
  EXPECT_FALSE(read["counts"].contains("MAP_UPDATE"));
  int n = 0;
  for (const json& text : read["told"])
    n += text.get<std::string>().find("MAP_UPDATE is from another version") != std::string::npos;
  EXPECT_EQ(n, 1) << read["told"];
}

TEST_F(Python, MessagesOfOtherProgramsAreNotOfAnotherVersion) {
  std::vector<std::string_view> names;
  for (const bus::Channel& channel : bus::Channels()) names.push_back(channel.name);
  const json told = Answer(fmt::format(R"(
import warnings
from plslam.wire import warn_of_version
def told(name, schema):
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        warn_of_version("x", name, bytes(8) + schema.to_bytes(4, "big") + bytes(32))
    return len(told)
names = "{}".split()
print(json.dumps([sum(told(name, 1) for name in names), len(names), told("POSE", 395000), told("COUNTER", 1)]))
)",
                                       fmt::join(names, " ")));
  EXPECT_EQ(told, json({names.size(), names.size(), 0, 0}));
}

TEST_F(Python, ListenerReceivesEachMessageOnce) {
  std::random_device random;
  bus::BusOptions options;
  options.url =
      fmt::format("udpm://239.255.{}.{}:{}?ttl=0", random() % 256, random() % 256, 20000 + random() % 20000);
  options.prefix = "front/";
  bus::Bus bus(options, "vo");
  folder().Write("url", options.url);
  std::atomic<bool> done = false;
  // The listener begins at some number, and from there on has every one that it is fast enough for: with these few,
  // all.
  std::thread publisher([&] {
    for (int i = 0; !done; ++i) {
      bus.Publish(bus::kPose, PoseNumber(i));
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
  });
  const json heard = Answer(R"(
out, silent = [], 0
for m in plslam.listen(open("url").read(), prefix="front/", channels=["POSE"], timeout_s=60):
    out.append([m.value.frame_id, m.value.header.seq, m.value.header.t_ns])
    if len(out) == 50:
        break
for m in plslam.listen(open("url").read(), prefix="rear/", timeout_s=0.2):
    silent += 1
try:
    plslam.listen("tcpq://localhost:7700")
    refused = "taken"
except ValueError as error:
    refused = str(error)
print(json.dumps({"heard": out, "silent": silent, "refused": refused}))
)");
  done = true;
  publisher.join();
  ASSERT_TRUE(heard.is_object());
  ASSERT_EQ(heard["heard"].size(), 50U);
  int last = -1;
  for (const json& row : heard["heard"]) {
    const int frame = row[0];
    EXPECT_GT(frame, last);
    EXPECT_EQ(row[1], frame);
    EXPECT_EQ(row[2], 1'700'000'000'123'456'789 + frame);
    last = frame;
  }
  EXPECT_EQ(heard["silent"], 0);
  EXPECT_THAT(heard["refused"].get<std::string>(), HasSubstr("can only listen to udpm://"));
}

TEST_F(Python, ForeignBytesAreNoMessage) {
  const json said = Answer(R"(
from plslam.wire import decode, parse_datagram
pose = plslam.pose_t()
data = pose.encode()
kinds = set()
for n in range(len(data)):
    try:
        kinds.add(type(decode(data[:n])).__name__)
    except ValueError:
        kinds.add("ValueError")
print(json.dumps({"whole": type(decode(data + b"a MAC behind it")).__name__, "cut": sorted(kinds),
                  "long": parse_datagram(b"LC03" + bytes(40)), "open": parse_datagram(b"LC02" + bytes(4) + b"POSE"),
                  "none": parse_datagram(b""), "name": parse_datagram(b"LC02\0\0\0\7POSE\0ab")[0]}))
)");
  ASSERT_TRUE(said.is_object());
  EXPECT_EQ(said["whole"], "pose_t");
  EXPECT_EQ(said["cut"], json({"NoneType", "ValueError"}));
  EXPECT_TRUE(said["long"].is_null() && said["open"].is_null() && said["none"].is_null());
  EXPECT_EQ(said["name"], "POSE");
}

TEST_F(Python, FilesOfARunEqualTheWrittenOnes) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-2.0, 2.0);
  Trajectory trajectory;
  std::vector<PoseCovariance> covariances;
  for (int i = 0; i < 30; ++i) {
    const int64_t t_ns = 1'700'000'000'123'456'789 + i * 33'333'333LL;
    Vector6d x;
    for (int k = 0; k < 6; ++k) x[k] = uniform(random);
    trajectory.push_back({t_ns, SE3::Exp(x)});
    covariances.push_back({t_ns, x * x.transpose()});
  }
  WriteTrajectory(folder().Path("trajectory.tum"), TrajectoryFormat::kTum, trajectory);
  WritePoseCovariances(folder().Path("covariance.txt"), covariances);
  folder().Write("poses.csv", "frame_id,t_s,state\n0,1.5,tracking\n1,1.75,lost\n");
  folder().Write("summary.json", "{\"frames\": 2}");
  const json run = Answer(R"(
r = plslam.load_run(".")
out = {"t_ns": r.trajectory.t_ns.tolist(), "T": r.trajectory.matrices().reshape(-1, 16).tolist(),
       "ct": r.covariance[0].tolist(), "C": r.covariance[1].reshape(-1, 36).tolist(), "frames": r.summary["frames"],
       "state": r.frames["state"].tolist(), "t_s": r.frames["t_s"].tolist(), "map": r.map is None, "live": r.live is None}
def why(name, text):
    open(name, "w", encoding="latin-1").write(text)
    try:
        plslam.load_run(".")
    except plslam.FileError as error:
        return str(error)
    return "taken"
out["errors"] = [why("trajectory.tum", "1 2 3 4 0 0 0 1\n2 2 x 4 0 0 0 1\n"), why("trajectory.tum", "# nothing\n\n1 2 3\n"),
                 why("trajectory.tum", "1 2 nan 4 0 0 0 1\n"),
                 why("trajectory.tum", "1e30 2 3 4 0 0 0 1\n"), why("trajectory.tum", "1e999999 2 3 4 0 0 0 1\n"),
                 why("trajectory.tum", "")[:0] + why("summary.json", "{"), why("summary.json", "[]"),
                 why("summary.json", "{}")[:0] + why("poses.csv", "a,b\n1\n"), why("poses.csv", "a,\xff\n1,2\n"),
                 why("poses.csv", "a\n" + 30 * "9" + "\n")]
import os
os.mkdir("empty")
try:
    plslam.load_run("empty")
except plslam.FileError as error:
    out["empty"] = str(error)
print(json.dumps(out))
)");
  ASSERT_TRUE(run.is_object());
  ASSERT_EQ(run["t_ns"].size(), trajectory.size());
  for (size_t i = 0; i < trajectory.size(); ++i) {
    EXPECT_EQ(run["t_ns"][i], trajectory[i].t_ns);
    ExpectNear(run["T"][i], Rows(MatrixOf(trajectory[i].T_a_b)), 1e-7);
    EXPECT_EQ(run["ct"][i], trajectory[i].t_ns);
    ExpectNear(run["C"][i], Numbers(covariances[i].covariance), 0.0);
  }
  EXPECT_EQ(run["frames"], 2);
  EXPECT_EQ(run["state"], json({"tracking", "lost"}));
  EXPECT_EQ(run["t_s"], json({1.5, 1.75}));
  EXPECT_TRUE(run["map"].get<bool>() && run["live"].get<bool>());
  EXPECT_THAT(run["errors"][0].get<std::string>(),
              HasSubstr("trajectory.tum:2: could not convert string to float: 'x'"));
  EXPECT_THAT(run["errors"][1].get<std::string>(), HasSubstr("trajectory.tum:3: 3 numbers instead of 8"));
  EXPECT_THAT(run["errors"][2].get<std::string>(), HasSubstr("trajectory.tum:1: a number that is not finite"));
  EXPECT_THAT(run["errors"][3].get<std::string>(), HasSubstr("trajectory.tum:1: the time 1e30 s"));
  EXPECT_THAT(run["errors"][4].get<std::string>(), HasSubstr("trajectory.tum:1: the time 1e999999 s"));
  EXPECT_THAT(run["errors"][5].get<std::string>(), HasSubstr("summary.json: "));
  EXPECT_THAT(run["errors"][6].get<std::string>(), HasSubstr("summary.json: is not a JSON object"));
  EXPECT_THAT(run["errors"][7].get<std::string>(), HasSubstr("poses.csv:2: 1 columns instead of 2"));
  EXPECT_THAT(run["errors"][8].get<std::string>(), HasSubstr("poses.csv: 'utf-8' codec"));
  EXPECT_EQ(run["errors"][9], "taken") << "a number that is too large for an integer is one all the same";
  EXPECT_THAT(run["empty"].get<std::string>(), HasSubstr("has no file of a run"));
}

TEST_F(Python, TypesPassMypy) {
  if (Shell(folder(), "mypy --version").exit_code != 0) GTEST_SKIP() << "no mypy here";
  // The generated types of messages have none.
  const ShellResult result =
      Shell(folder(),
            fmt::format(
                "cd '{0}/plslam' && mypy --cache-dir=/dev/null --python-executable /usr/bin/python3 "
                "--disallow-untyped-defs --follow-imports=silent __init__.py errors.py images.py log.py map_file.py "
                "run.py wire.py",
                PLSLAM_PYTHON_FOLDER));
  EXPECT_EQ(result.exit_code, 0) << result.out << result.error;
}

/// Runs the example of docs/python.md on files with its names.
TEST_F(Python, TheExampleOfTheDocumentRuns) {
  StoredMap stored = RandomStoredMap(9, 300);
  stored.rig = CameraBytes({420.5, 375.25, 239.75, 0.11, 752, 480});
  std::filesystem::create_directories(folder().Path("at/out/room"));
  WriteMapFile(folder().Path("at/room.plmap"), stored);
  Trajectory trajectory;
  for (int i = 0; i < 5; ++i) trajectory.push_back({1'700'000'000'000'000'000 + i * 100'000'000LL, SE3()});
  WriteTrajectory(folder().Path("at/out/room/trajectory.tum"), TrajectoryFormat::kTum, trajectory);
  WriteTrajectory(folder().Path("at/out/room/trajectory_live.tum"), TrajectoryFormat::kTum, trajectory);
  {
    bus::BusOptions options;
    options.url = "file://" + folder().Path("at/run.lcm") + "?mode=w";
    bus::Bus bus(options, "vo");
    status_t status{};
    status.process = "vo";
    status.state = "running";
    bus.Publish(bus::kStatus, status);
  }
  std::ifstream document(SourceFolder() / "docs/python.md");
  const std::string text{std::istreambuf_iterator<char>(document), {}};
  const std::string fence = "```python\n";
  const size_t begin = text.find(fence) + fence.size();
  ASSERT_GT(begin, fence.size());
  const ShellResult result = Run("import os\nos.chdir('at')\n" + text.substr(begin, text.find("```", begin) - begin));
  EXPECT_EQ(result.exit_code, 0) << result.error;
  EXPECT_THAT(result.out, testing::AllOf(HasSubstr("f_px=420.5"), HasSubstr("observations of a point, at most: "),
                                         HasSubstr("vo running")));
}

/// With a drawing library that only records its calls.
TEST_F(Python, TheLiveExampleDrawsThePathOfARun) {
  std::random_device random;
  bus::BusOptions options;
  options.url =
      fmt::format("udpm://239.255.{}.{}:{}?ttl=0", random() % 256, random() % 256, 20000 + random() % 20000);
  bus::Bus bus(options, "vo");
  std::atomic<bool> done = false;
  std::thread publisher([&] {
    for (int i = 0; !done; ++i) {
      bus.Publish(bus::kPose, PoseNumber(i));
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
  });
  const json drawn =
      Answer(fmt::format(R"(
import runpy, types
drawn = []
class Enough(Exception):
    pass
class Line:
    def set_data(self, x, z):
        drawn.append([list(x), list(z)])
        if len(drawn) == 3:
            raise Enough
axes = types.SimpleNamespace(set_aspect=lambda how: None, relim=lambda: None, autoscale_view=lambda: None)
nothing = lambda *more: None
pyplot = types.ModuleType("matplotlib.pyplot")
vars(pyplot).update(plot=lambda x, z: (Line(),), gca=lambda: axes, xlabel=nothing, ylabel=nothing, ion=nothing, show=nothing,
                    pause=nothing)
package = types.ModuleType("matplotlib")
package.pyplot = pyplot
sys.modules.update({{"matplotlib": package, "matplotlib.pyplot": pyplot}})
sys.argv = ["live_plot.py", "{}"]
try:
    runpy.run_path("{}")
except Enough:
    pass
print(json.dumps(drawn))
)",
                         options.url, (SourceFolder() / "tools/python/examples/live_plot.py").string()));
  done = true;
  publisher.join();
  ASSERT_EQ(drawn.size(), 3U);
  ASSERT_EQ(drawn[2][1].size(), 30U);
  EXPECT_EQ(drawn[2][0], json(std::vector<double>(30, 0.0)));
  for (int i = 1; i < 30; ++i) {
    EXPECT_GE(drawn[2][1][i].get<double>(), drawn[2][1][i - 1].get<double>() + 0.25);
  }
}

TEST_F(Python, TheExampleMakesArrays) {
  StoredMap stored = RandomStoredMap(9, 300);
  stored.rig = CameraBytes({420.5, 375.25, 239.75, 0.11, 752, 480});
  WriteMapFile(folder().Path("map.plmap"), stored);
  const std::string example = (SourceFolder() / "tools/python/examples/map_to_arrays.py").string();
  const json arrays = Answer(fmt::format(R"(
import runpy
sys.argv = ["map_to_arrays.py", "map.plmap", "out.npz"]
sys.stdout = sys.stderr
runpy.run_path("{}")
sys.stdout = sys.__stdout__
data = np.load("out.npz")
print(json.dumps({{name: list(data[name].shape) for name in data}}))
)",
                                         example));
  ASSERT_TRUE(arrays.is_object());
  const size_t lines = stored.map.lines().size();
  EXPECT_EQ(arrays["points"], json({stored.map.points().size(), 3}));
  EXPECT_EQ(arrays["line_ends"], json({2 * lines, 3}));
  EXPECT_EQ(arrays["lines"], json({lines, 2}));
  EXPECT_EQ(arrays["path"], json({stored.map.keyframes().size(), 3}));
}

}  // namespace
}  // namespace plslam::test
