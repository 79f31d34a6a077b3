// SPDX-License-Identifier: Apache-2.0
#include <benchmark/benchmark.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstring>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "bare_ring.hpp"
#include "pipescout/dds/dds_transport.hpp"
#include "pipescout/runtime/node.hpp"
#include "plain_fastdds/plain_fastdds.hpp"
#include "samples.hpp"
#include "transport_benchmark.hpp"

namespace pipescout::benchmarks {

namespace {

using sensor_msgs::msg::Image;

constexpr int kIterations = 100;
// Messages come at the pace of a fast sensor. Without pauses the fragments of an image meet warm
// threads that keep up, and plain Fast DDS loses fewer of them than it does in real use.
constexpr auto kPause = std::chrono::milliseconds(10);
constexpr int kPatienceMilliseconds = 1000;

void write_latency(int pipe, double microseconds) {
  // A pipe takes a double whole; the parent waits for it before it sends the next message.
  if (write(pipe, &microseconds, sizeof microseconds) != sizeof microseconds) {
    _exit(1);
  }
}

std::string ring_name(std::uint32_t domain) {
  return "/pipescout_bare_ring_" + std::to_string(domain);
}

/// The time of sending, in the first bytes of a message.
void stamp_bytes(std::vector<std::uint8_t>& bytes) {
  const std::int64_t now = monotonic_nanoseconds();
  std::memcpy(bytes.data(), &now, sizeof now);
}

[[noreturn]] void receive_bare(BareRing& ring, int pipe) {
  std::vector<std::uint8_t> bytes(BareRing::kSlotBytes);
  for (;;) {
    ring.receive(bytes);
    std::int64_t sent = 0;
    std::memcpy(&sent, bytes.data(), sizeof sent);
    write_latency(pipe, static_cast<double>(monotonic_nanoseconds() - sent) * 1e-3);
  }
}

/// The subscriber's process: writes each latency to a pipe, and ends when its parent does.
int receive(std::uint32_t domain, int pipe) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  Executor executor;
  const auto context =
      Context::create(create_dds_transport({.domain_id = domain, .localhost_only = true}));
  Node node({.context = context,
             .executor = &executor,
             .name = {"/", "receiver"},
             .standard_interfaces = false});
  const auto report = [pipe](const Image& image) {
    write_latency(pipe, microseconds_since_stamp(image));
  };
  const auto image = node.create_subscription<Image>("image", QoS::reliable(), report);
  const auto small = node.create_subscription<Image>("small", QoS::reliable(), report);
  const auto participant = create_plain_participant(domain);
  const PlainReader plain_image(participant, "plain_image", report);
  const PlainReader plain_small(participant, "plain_small", report, PlainCallback::kInThread);
  const PlainReader plain_listener(participant, "plain_listener", report);
  BareRing ring(ring_name(domain));
  std::thread([&ring, pipe] { receive_bare(ring, pipe); }).detach();  // until the process is killed
  executor.spin();
  return 0;
}

/// This process's ends, and the child with the others. Lives for the whole run.
class Link {
 public:
  static Link& instance() {
    static Link link;
    return link;
  }

  double send_ours(Publisher<Image>& publisher, ImageSize size) {
    auto message = make_image(size);
    stamp(*message);
    publisher.publish(std::move(message));
    return await();
  }
  double send_plain(PlainWriter& writer, ImageSize size) {
    auto message = make_image(size);
    stamp(*message);
    writer.write(*message);
    return await();
  }

  double send_bare(ImageSize size) {
    const auto message = make_image(size);
    stamp_bytes(message->data);
    ring_.send(message->data);
    return await();
  }

  Publisher<Image> image;
  Publisher<Image> small;
  std::unique_ptr<PlainWriter> plain_image;
  std::unique_ptr<PlainWriter> plain_small;
  std::unique_ptr<PlainWriter> plain_listener;

 private:
  Link() {
    std::array<int, 2> ends{};
    if (pipe(ends.data()) != 0) {
      throw std::runtime_error("no pipe");
    }
    pipe_ = ends[0];
    const std::string domain = std::to_string(benchmark_domain());
    const std::string out = std::to_string(ends[1]);
    child_ = fork();
    if (child_ == 0) {
      execl("/proc/self/exe", "transport_benchmark", "--receive", domain.c_str(), out.c_str(),
            nullptr);
      _exit(127);
    }
    close(ends[1]);
    context_ = Context::create(
        create_dds_transport({.domain_id = benchmark_domain(), .localhost_only = true}));
    node_ = std::make_unique<Node>(NodeOptions{.context = context_,
                                               .executor = &executor_,
                                               .name = {"/", "sender"},
                                               .standard_interfaces = false});
    image = node_->create_publisher<Image>("image", QoS::reliable());
    small = node_->create_publisher<Image>("small", QoS::reliable());
    participant_ = create_plain_participant(benchmark_domain());
    plain_image = std::make_unique<PlainWriter>(participant_, "plain_image");
    plain_small = std::make_unique<PlainWriter>(participant_, "plain_small");
    plain_listener = std::make_unique<PlainWriter>(participant_, "plain_listener");
    // Until each path has carried a message: matched on both sides, and warm.
    const auto until_heard = [&](const std::function<double()>& send) {
      for (int attempt = 0; attempt < 100; ++attempt) {
        if (send() >= 0.0) {
          return;
        }
      }
      throw std::runtime_error("the receiving process does not answer");
    };
    until_heard([&] { return send_ours(image, kThermalImage); });
    until_heard([&] { return send_ours(image, kSixMegabytes); });
    until_heard([&] { return send_bare(kSixMegabytes); });
    until_heard([&] { return send_ours(small, kOneKilobyte); });
    until_heard([&] { return send_plain(*plain_image, kThermalImage); });
    until_heard([&] { return send_plain(*plain_small, kOneKilobyte); });
    until_heard([&] { return send_plain(*plain_listener, kOneKilobyte); });
  }

  ~Link() {
    kill(child_, SIGKILL);
    waitpid(child_, nullptr, 0);
    close(pipe_);
    BareRing::remove(ring_name(benchmark_domain()));
  }

  /// The latency that the child measured; negative when the message was lost, or when more than one
  /// came: a late one would be taken for the next.
  double await() {
    pollfd readable{pipe_, POLLIN, 0};
    double latency = -1.0;
    if (poll(&readable, 1, kPatienceMilliseconds) == 1 &&
        read(pipe_, &latency, sizeof latency) == sizeof latency && poll(&readable, 1, 0) == 0) {
      return latency;
    }
    return -1.0;
  }

  BareRing ring_{ring_name(benchmark_domain())};
  int pipe_ = -1;
  pid_t child_ = -1;
  Executor executor_;
  std::shared_ptr<Context> context_;
  std::unique_ptr<Node> node_;
  std::shared_ptr<PlainParticipant> participant_;
};

template <class Send>
void register_case(const std::string& name, Send send) {
  benchmark::RegisterBenchmark(name.c_str(),
                               [name, send](benchmark::State& state) {
                                 Link& link = Link::instance();
                                 for (auto _ : state) {
                                   // No event: the pace of a sensor.
                                   std::this_thread::sleep_for(kPause);
                                   const double latency = send(link);
                                   if (latency < 0.0) {
                                     state.SkipWithError("a message was lost");
                                     return;
                                   }
                                   state.SetIterationTime(latency / 1e6);
                                   all_samples()[name].add(latency);
                                 }
                               })
      ->UseManualTime()
      ->Iterations(kIterations)
      ->Unit(benchmark::kMicrosecond);
}

}  // namespace

void register_cross_process() {
  register_case("across processes, image, ours",
                [](Link& link) { return link.send_ours(link.image, kThermalImage); });
  register_case("across processes, image, bare ring",
                [](Link& link) { return link.send_bare(kThermalImage); });
  register_case("across processes, 6 MB, ours",
                [](Link& link) { return link.send_ours(link.image, kSixMegabytes); });
  register_case("across processes, 6 MB, bare ring",
                [](Link& link) { return link.send_bare(kSixMegabytes); });
  register_case("across processes, image, plain Fast DDS",
                [](Link& link) { return link.send_plain(*link.plain_image, kThermalImage); });
  register_case("across processes, 1 kB, ours",
                [](Link& link) { return link.send_ours(link.small, kOneKilobyte); });
  register_case("across processes, 1 kB, plain Fast DDS",
                [](Link& link) { return link.send_plain(*link.plain_small, kOneKilobyte); });
  register_case("across processes, 1 kB, plain Fast DDS, in its listener",
                [](Link& link) { return link.send_plain(*link.plain_listener, kOneKilobyte); });
}

int run_as_receiver(int argc, char** argv) {
  if (argc == 4 && std::strcmp(argv[1], "--receive") == 0) {
    return receive(static_cast<std::uint32_t>(std::stoul(argv[2])), std::stoi(argv[3]));
  }
  return -1;
}

}  // namespace pipescout::benchmarks
