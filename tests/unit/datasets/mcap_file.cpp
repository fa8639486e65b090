// SPDX-License-Identifier: BSD-3-Clause
#include "tests/unit/datasets/mcap_file.h"

#include <lz4frame.h>
#include <zlib.h>
#include <zstd.h>

#include <cstdint>
#include <map>
#include <vector>

#include "core/io/files/bytes.h"
#include "tests/unit/datasets/dataset_folders.h"

namespace plslam::test {
namespace {

enum Channel : uint16_t { kLeft, kRight, kLeftInfo, kRightInfo, kTruth };

class Bytes {
 public:
  template <class Number>
  Bytes& Add(Number value) {
    AppendLittleEndian(value, bytes_);
    return *this;
  }
  Bytes& Text(const std::string& text) {
    Add(static_cast<uint32_t>(text.size()));
    bytes_ += text;
    return *this;
  }
  Bytes& Raw(const std::string& bytes) {
    bytes_ += bytes;
    return *this;
  }
  /// CDR: a number at a multiple of its size behind the four bytes of the encoding.
  template <class Number>
  Bytes& Cdr(Number value) {
    while ((bytes_.size() - 4) % sizeof(Number) != 0) bytes_ += '\0';
    return Add(value);
  }
  Bytes& CdrText(const std::string& text) {
    Cdr(static_cast<uint32_t>(text.size() + 1));
    bytes_ += text + '\0';
    return *this;
  }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

std::string Record(uint8_t kind, const std::string& content) {
  return Bytes().Add(kind).Add(static_cast<uint64_t>(content.size())).Raw(content).bytes();
}

uint32_t Crc(const std::string& bytes) {
  return static_cast<uint32_t>(crc32_z(0, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

std::string Compressed(const std::string& in, const std::string& compression) {
  if (compression.empty()) return in;
  std::string out(in.size() + 1000, '\0');
  const size_t n = compression == "lz4" ? LZ4F_compressFrame(out.data(), out.size(), in.data(), in.size(), nullptr)
                                        : ZSTD_compress(out.data(), out.size(), in.data(), in.size(), 1);
  return out.substr(0, n);
}

Bytes Message(int64_t t_ns) {
  Bytes cdr;
  cdr.Raw(std::string("\0\1\0\0", 4));
  cdr.Cdr(static_cast<int32_t>(t_ns / 1'000'000'000)).Cdr(static_cast<uint32_t>(t_ns % 1'000'000'000));
  cdr.CdrText("camera");
  return cdr;
}

std::string Image(int64_t t_ns, int frame, int camera, const std::string& encoding) {
  Bytes cdr = Message(t_ns);
  cdr.Cdr(uint32_t{kTinyHeight_px}).Cdr(uint32_t{kTinyWidth_px}).CdrText(encoding).Cdr(uint8_t{0});
  const uint32_t channels = encoding == "rgb8" ? 3 : 1;
  cdr.Cdr(uint32_t{kTinyWidth_px} * channels).Cdr(uint32_t{kTinyWidth_px} * kTinyHeight_px * channels);
  for (int y = 0; y < kTinyHeight_px; ++y) {
    for (int x = 0; x < kTinyWidth_px; ++x) {
      for (uint32_t c = 0; c < channels; ++c) cdr.Add(static_cast<uint8_t>(TinyPixel(frame, camera, x, y)));
    }
  }
  return cdr.bytes();
}

std::string CameraInfo(int64_t t_ns, double p3) {
  Bytes cdr = Message(t_ns);
  cdr.Cdr(uint32_t{kTinyHeight_px}).Cdr(uint32_t{kTinyWidth_px}).CdrText("plumb_bob").Cdr(uint32_t{5});
  for (const double d : {-0.28, 0.07, 0.0002, 1.8e-5, 0.0}) cdr.Cdr(d);
  for (const double k : {40.0, 0.0, 24.0, 0.0, 40.0, 16.0, 0.0, 0.0, 1.0}) cdr.Cdr(k);
  for (const double r : {1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0}) cdr.Cdr(r);
  for (const double p : {40.0, 0.0, 24.0, p3, 0.0, 40.0, 16.0, 0.0, 0.0, 0.0, 1.0, 0.0}) cdr.Cdr(p);
  return cdr.bytes();
}

std::string Pose(int64_t t_ns, int frame) {
  Bytes cdr = Message(t_ns);
  for (const double x : {1.0 * frame, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0}) cdr.Cdr(x);
  return cdr.bytes();
}

std::map<uint16_t, std::string> Messages(int64_t t_ns, int frame, const McapFileOptions& o) {
  return {{kLeft, Image(t_ns, frame, 0, o.encoding)},
          {kRight, Image(t_ns, frame, 1, o.encoding)},
          {kLeftInfo, CameraInfo(t_ns, 0.0)},
          {kRightInfo, CameraInfo(t_ns, o.p_right)},
          {kTruth, Pose(t_ns, frame)}};
}

}  // namespace

void MakeMcapFile(const std::filesystem::path& path, const McapFileOptions& o) {
  const std::string magic("\x89MCAP0\r\n", 8);
  std::string file = magic + Record(1, Bytes().Text("ros2").Text("test").bytes());
  std::string chunk_indices;
  for (int i = 0; i < 3; ++i) {
    const int frame = o.unsorted ? 2 - i : i;
    const int64_t t_ns = 1'000'000'000 + 100'000'000 * int64_t{frame};
    std::string chunk;
    std::map<uint16_t, uint64_t> offsets;
    for (const auto& [channel, cdr] : Messages(t_ns, frame, o)) {
      offsets[channel] = chunk.size();
      chunk += Record(5, Bytes().Add(channel).Add(uint32_t{0}).Add(t_ns).Add(t_ns).Raw(cdr).bytes());
    }
    const std::string packed = Compressed(chunk, o.compression);
    Bytes content;
    content.Add(t_ns).Add(t_ns).Add(static_cast<uint64_t>(chunk.size())).Add(o.checksums ? Crc(chunk) : 0U);
    content.Text(o.compression).Add(static_cast<uint64_t>(packed.size())).Raw(packed);
    const uint64_t chunk_at = file.size();
    const std::string record = Record(6, content.bytes());
    file += record;
    Bytes places;
    for (const auto& [channel, offset] : offsets) {
      places.Add(channel).Add(static_cast<uint64_t>(file.size()));
      file += Record(7, Bytes().Add(channel).Text(Bytes().Add(t_ns).Add(offset).bytes()).bytes());
    }
    Bytes index;
    index.Add(t_ns).Add(t_ns).Add(chunk_at).Add(static_cast<uint64_t>(record.size())).Text(places.bytes());
    index.Add(uint64_t{0}).Text(o.compression).Add(uint64_t{0}).Add(uint64_t{0});
    chunk_indices += Record(8, index.bytes());
  }
  file += Record(0x0f, Bytes().Add(uint32_t{0}).bytes());
  const uint64_t summary_at = file.size();
  std::string summary;
  const std::vector<std::string> types{"sensor_msgs/msg/Image", "sensor_msgs/msg/CameraInfo",
                                       "geometry_msgs/msg/PoseStamped"};
  for (uint16_t i = 0; i < types.size(); ++i) {
    summary += Record(3, Bytes().Add(static_cast<uint16_t>(i + 1)).Text(types[i]).Text("ros2msg").Text("").bytes());
  }
  const std::string left_space = o.left.substr(0, o.left.rfind('/')),
                    right_space = o.right.substr(0, o.right.rfind('/'));
  const std::vector<std::pair<std::string, uint16_t>> channels{{o.left, uint16_t{1}},
                                                               {o.right, uint16_t{1}},
                                                               {left_space + "/camera_info", uint16_t{2}},
                                                               {right_space + "/camera_info", uint16_t{2}},
                                                               {"/ground_truth", uint16_t{3}}};
  for (uint16_t i = 0; i < channels.size(); ++i) {
    summary += Record(4, Bytes().Add(i).Add(channels[i].second).Text(channels[i].first).Text("cdr").Text("").bytes());
  }
  summary += chunk_indices;
  std::string footer = Record(2, Bytes().Add(summary_at).Add(uint64_t{0}).Add(uint32_t{0}).bytes());
  if (o.checksums) {
    footer.resize(footer.size() - 4);
    footer += Bytes().Add(Crc(summary + footer)).bytes();
  }
  WriteText(path, file + summary + footer + magic);
}

}  // namespace plslam::test
