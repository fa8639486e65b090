// SPDX-License-Identifier: BSD-3-Clause
#include "core/bus/messages/frame_channel.h"

#include <algorithm>
#include <atomic>
#include <map>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <utility>

#include "core/bus/messages/convert.h"
#include "core/bus/messages/frame_assembler.h"
#include "core/bus/run_loop.h"
#include "core/bus/transport/wire.h"
#include "core/errors/log.h"
#include "plslam/camera_t.hpp"
#include "plslam/image_strip_t.hpp"

namespace plslam::bus {

struct CameraSubscriber::State {
  Handler handler;
  std::function<void()> on_rejected;
  std::vector<uint8_t> bytes;                     // of the camera in use
  std::map<SourceId, std::vector<uint8_t>> rigs;  // newest, by publisher
  std::optional<SourceId> followed;               // publisher of the frames
  double followed_since_s = 0.0;

  bool HasRigOfFrames() const { return !followed || rigs.contains(*followed); }

  void Take(SourceId publisher, const camera_t& message) {
    static constexpr size_t kMaxSources = 256;
    if (rigs.size() >= kMaxSources) std::erase_if(rigs, [this](const auto& rig) { return rig.first != followed; });
    const std::vector<uint8_t>& heard = rigs[publisher] = RigBytes(message);
    if (!followed || publisher == *followed || !rigs.contains(*followed)) Use(heard);
  }

  void Follow(SourceId publisher) {
    if (followed == publisher) return;
    followed = publisher;
    followed_since_s = NowS();
    const auto known = rigs.find(publisher);
    if (known != rigs.end()) Use(known->second);
  }

  void Use(const std::vector<uint8_t>& heard) {
    if (heard == bytes) return;
    bytes = heard;
    const auto message = Decoded<camera_t>(bytes);
    const std::optional<RigCalibration> rig = message ? FromMessage(*message) : std::nullopt;
    if (rig) return handler(*rig);
    LogError("the camera '{}' has invalid values: it is not used", message ? message->rig_name : "");
    if (on_rejected) on_rejected();
  }
};

CameraSubscriber::CameraSubscriber(Bus& bus, Handler handler, std::function<void()> on_rejected)
    : state_(std::make_shared<State>()) {
  state_->handler = std::move(handler);
  state_->on_rejected = std::move(on_rejected);
  bus.Subscribe<camera_t>(kCamera, [weak = std::weak_ptr<State>(state_)](const camera_t& message) {
    if (const auto state = weak.lock()) state->Take(SourceId(message.header.source), message);
  });
}

void CameraSubscriber::Follow(SourceId publisher) { state_->Follow(publisher); }

bool CameraSubscriber::awaits_rig() const {
  // A lost rig is repeated after a second.
  constexpr double kPatience_s = 2.0;
  return !state_->HasRigOfFrames() && NowS() - state_->followed_since_s < kPatience_s;
}

const std::vector<uint8_t>& CameraSubscriber::bytes() const { return state_->bytes; }

void CameraSubscriber::Restore(const std::vector<uint8_t>& bytes, SourceId publisher) {
  const auto message = Decoded<camera_t>(bytes);
  if (!message) throw std::runtime_error("its camera is damaged");
  state_->Take(publisher, *message);
}

namespace {

const char* EncodingOf(const cv::Mat& image, bool is_right) {
  if (image.type() == CV_8UC1) return strip_encoding::kGrey;
  if (image.type() == CV_16UC1 && is_right) return strip_encoding::kDepth;
  throw std::invalid_argument("a frame needs 8-bit grey images, or a 16-bit depth map on the right; OpenCV type " +
                              std::to_string(image.type()) + " is neither");
}

/// Returns the image bytes in each strip: complete rows if one fits, otherwise as many bytes as fit.
int64_t StripBytes(const image_strip_t& empty, int64_t row_bytes, int64_t page_bytes) {
  const int64_t room = page_bytes - empty.getEncodedSize();
  if (room < 256) throw std::invalid_argument("bus.max_message_bytes leaves no room for images");
  return room >= row_bytes ? room / row_bytes * row_bytes : room;
}

void CheckSize(const StereoImages& frame, const cv::Mat& image) {
  if (image.empty()) throw std::invalid_argument("a frame needs two images");
  if (FrameAssembler::CanHold(image.cols, image.rows, static_cast<int64_t>(image.elemSize()))) return;
  throw std::runtime_error("frame " + std::to_string(frame.frame_id.value) + ": an image of " +
                           std::to_string(image.cols) + " x " + std::to_string(image.rows) + " pixels, " +
                           std::to_string(image.elemSize()) + " bytes each, is larger than readers accept (" +
                           std::to_string(FrameAssembler::kMaxImageBytes) + " bytes, " +
                           std::to_string(FrameAssembler::kMaxSide_px) + " pixels a side)");
}

}  // namespace

FramePublisher::FramePublisher(Bus& bus, bool lockstep) : bus_(bus), lockstep_(lockstep) {}

void FramePublisher::Publish(const StereoImages& images) {
  CheckSize(images, images.left);
  CheckSize(images, images.right);
  PublishImage(images, images.left, 0);
  PublishImage(images, images.right, 1);
}

void FramePublisher::PublishImage(const StereoImages& frame, const cv::Mat& image, int8_t camera) {
  const cv::Mat whole = image.isContinuous() ? image : image.clone();
  image_strip_t strip{};
  strip.header.t_ns = frame.t_ns;
  strip.frame_id = frame.frame_id.value;
  strip.camera = camera;
  strip.width_px = whole.cols;
  strip.height_px = whole.rows;
  strip.encoding = EncodingOf(whole, camera == 1);
  const auto total = static_cast<int64_t>(whole.total() * whole.elemSize());
  const int64_t run = StripBytes(strip, total / whole.rows, bus_.page_bytes());
  strip.n_strips = static_cast<int32_t>((total + run - 1) / run);
  for (int64_t offset = 0; offset < total; offset += run, ++strip.strip) {
    const int64_t end = std::min(total, offset + run);
    strip.offset_bytes = static_cast<int32_t>(offset);
    strip.n_bytes = static_cast<int32_t>(end - offset);
    strip.data.assign(whole.data + offset, whole.data + end);
    bus_.Publish(lockstep_ ? kStereoFrame : kStereoFrameLive, strip);
  }
}

/// Strips arrive on the receiving thread; frames go to the handler on the thread of Run. Kept alive by the
/// subscriptions of the bus through weak pointers only.
struct FrameSubscriber::Impl : std::enable_shared_from_this<FrameSubscriber::Impl> {
  Impl(Bus& bus_in, Mode mode_in, std::function<void(const Frame&)> handler_in,
       std::function<bool(FrameId)> wanted_in, int most_in_real_time_in)
      : bus(bus_in),
        mode(mode_in),
        handler(std::move(handler_in)),
        wanted(std::move(wanted_in)),
        most_in_real_time(most_in_real_time_in) {}

  /// One of the two channels.
  struct Lane {
    bool lockstep = false;
    FrameAssembler assembler;
    std::map<SourceId, FrameId> completed;  // newest whole frame, by publisher
    image_strip_t strip;                    // kept for its memory
  };

  void Subscribe(const Channel& channel, Lane& lane);
  bool Ready() const { return waiting < kMostWaiting; }
  void OnStrip(Lane& lane, ByteView bytes);
  void OnFrame(Lane& lane, AssembledFrame frame);
  void Queue(AssembledFrame frame, bool lockstep);
  void OfferNewest(AssembledFrame frame);
  void Deliver(AssembledFrame frame, bool lockstep);
  static int Skipped(const AssembledFrame& last, const AssembledFrame& frame);

  Bus& bus;
  const Mode mode;
  const std::function<void(const Frame&)> handler;
  const std::function<bool(FrameId)> wanted;
  const int most_in_real_time;
  Lane ordered{true, {}, {}, {}};
  Lane live{false, {}, {}, {}};
  std::atomic<int> waiting = 0;

  std::mutex newest_mutex;
  std::optional<AssembledFrame> newest;     // live frame that waits for the handler
  std::map<SourceId, AssembledFrame> last;  // last delivered by publisher, without images (thread of Run)
};

void FrameSubscriber::Impl::Subscribe(const Channel& channel, Lane& lane) {
  using Reading = Bus::Reading;
  const Reading in_real_time = mode == Mode::kReliable ? Reading::kPaced : Reading::kAsItComes;
  const Reading reading = lane.lockstep ? Reading::kOrdered : in_real_time;
  const std::weak_ptr<Impl> weak = weak_from_this();
  bus.SubscribeBytes(
      channel, reading,
      [weak] {
        const auto self = weak.lock();
        return self == nullptr || self->Ready();
      },
      [weak, &lane](ByteView bytes) {
        if (const auto self = weak.lock()) self->OnStrip(lane, bytes);
      });
}

void FrameSubscriber::Impl::OnStrip(Lane& lane, ByteView bytes) {
  const SourceId source = ReadHeader(bytes).source;
  const FrameId frame_id(ReadInt64(bytes.data() + kWireHeaderBytes));
  const auto known = lane.completed.find(source);
  // On the ordered channel each strip arrives once: a repeated frame was sent again, for example by a player that has
  // gone back.
  if (!lane.lockstep && known != lane.completed.end() && frame_id <= known->second) return;
  if (wanted && !wanted(frame_id)) return;
  if (lane.strip.decode(bytes.data(), 0, static_cast<int>(bytes.size())) < 0) return;
  switch (lane.assembler.Add(lane.strip)) {
    case FrameAssembler::Outcome::kNonsense:
      bus.CountRejected();
      break;
    case FrameAssembler::Outcome::kComplete:
      OnFrame(lane, lane.assembler.TakeFrame());
      break;
    case FrameAssembler::Outcome::kTaken:
    case FrameAssembler::Outcome::kRepeated:
      break;
  }
}

void FrameSubscriber::Impl::OnFrame(Lane& lane, AssembledFrame frame) {
  static constexpr size_t kMaxSources = 256;
  if (lane.completed.size() >= kMaxSources) lane.completed.clear();
  lane.completed[frame.source] = frame.images.frame_id;
  frame.came_s = NowS();
  // Older unfinished frames will not be completed: their strips are lost or, in lockstep, given up.
  lane.assembler.Forget(frame.source, frame.images.frame_id);
  if (lane.lockstep) return Queue(std::move(frame), true);
  if (mode == Mode::kReliable) return OfferNewest(std::move(frame));
  if (waiting < most_in_real_time) Queue(std::move(frame), false);
}

void FrameSubscriber::Impl::Queue(AssembledFrame frame, bool lockstep) {
  ++waiting;
  bus.Post([weak = weak_from_this(), lockstep, frame = std::move(frame)]() mutable {
    const auto self = weak.lock();
    if (self == nullptr) return;
    --self->waiting;
    self->Deliver(std::move(frame), lockstep);
  });
}

void FrameSubscriber::Impl::OfferNewest(AssembledFrame frame) {
  const std::lock_guard lock(newest_mutex);
  const bool task_waits = newest.has_value();
  newest = std::move(frame);
  if (task_waits) return;
  bus.Post([weak = weak_from_this()] {
    const auto self = weak.lock();
    if (self == nullptr) return;
    std::unique_lock taking(self->newest_mutex);
    AssembledFrame taken = std::move(*std::exchange(self->newest, std::nullopt));
    taking.unlock();
    self->Deliver(std::move(taken), false);
  });
}

/// Returns the number of frames between two, from the numbers of their strips, since ids may have a stride; but at most
/// the number of ids between them: the number of a strip may be forged.
int FrameSubscriber::Impl::Skipped(const AssembledFrame& last, const AssembledFrame& frame) {
  const int64_t strips = frame.first_seq - last.first_seq;
  if (strips <= 0 || last.n_strips <= 0) return 0;
  const int64_t ids = std::max<int64_t>(0, frame.images.frame_id.value - last.images.frame_id.value - 1);
  return static_cast<int>(std::min((strips - 1) / last.n_strips, ids));
}

void FrameSubscriber::Impl::Deliver(AssembledFrame frame, bool lockstep) {
  Frame out{frame.images, frame.source, lockstep, 0, frame.came_s};
  const auto previous = last.find(frame.source);
  if (previous != last.end()) out.skipped = Skipped(previous->second, frame);
  if (!lockstep && mode == Mode::kReliable && out.skipped > 0) bus.CountSkipped(out.skipped);
  frame.images.left = frame.images.right = cv::Mat();
  static constexpr size_t kMaxSources = 256;
  if (last.size() >= kMaxSources) last.clear();
  last[frame.source] = frame;
  handler(out);
}

FrameSubscriber::FrameSubscriber(Bus& bus, Mode mode, std::function<void(const Frame&)> handler,
                                 std::function<bool(FrameId frame_id)> wanted, int most_in_real_time)
    : impl_(std::make_shared<Impl>(bus, mode, std::move(handler), std::move(wanted), most_in_real_time)) {
  impl_->Subscribe(kStereoFrame, impl_->ordered);
  impl_->Subscribe(kStereoFrameLive, impl_->live);
}

FrameSubscriber::~FrameSubscriber() = default;

}  // namespace plslam::bus
