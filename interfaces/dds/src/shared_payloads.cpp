// SPDX-License-Identifier: Apache-2.0
#include "shared_payloads.hpp"

#include <fcntl.h>
#include <linux/futex.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <ctime>
#include <fstream>
#include <limits>
#include <new>
#include <string_view>
#include <system_error>
#include <utility>

namespace pipescout::dds {
namespace {

// Representation identifiers from 0x8000 on are the vendors' (DDSI-RTPS 2.5, section 10.2.1.2).
constexpr std::array<std::byte, 4> kEncapsulation{std::byte{0x80}, std::byte{0x50}, std::byte{0},
                                                  std::byte{1}};

// The header has a page of its own: readers may write there and nowhere else.
constexpr std::size_t kPage = 4096;

// A block is an eighth larger than its first message, for messages that vary a little.
constexpr std::size_t kSlackShare = 8;

// Part of the free memory that one block may take, so that others find room too.
constexpr std::uintmax_t kRoomShare = 2;

constexpr unsigned kReaderBits = 16;
constexpr std::uint64_t kReaderMask = (std::uint64_t{1} << kReaderBits) - 1;

/// What writer and readers share of a block.
struct BlockHeader {
  /// Sequence number of the contents, and in the lowest bits how many readers have not taken them;
  /// 0 while the block is written.
  std::atomic<std::uint64_t> state{0};
  std::atomic<std::uint32_t> retired{0};  ///< the file is gone, and so should be the mappings
};
static_assert(std::atomic<std::uint64_t>::is_always_lock_free);
static_assert(sizeof(BlockHeader) <= kPage);

std::string file_name(const GuidPrefix& participant, std::uint32_t block) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string name(kPayloadPrefix);
  for (const std::uint8_t byte : participant) {
    name += kDigits[byte >> 4U];
    name += kDigits[byte & 0xFU];
  }
  return name + "_" + std::to_string(block);
}

class FileDescriptor {
 public:
  explicit FileDescriptor(int descriptor) noexcept : descriptor_(descriptor) {}
  FileDescriptor(const FileDescriptor&) = delete;
  FileDescriptor& operator=(const FileDescriptor&) = delete;
  ~FileDescriptor() {
    if (descriptor_ >= 0) {
      close(descriptor_);
    }
  }
  [[nodiscard]] int get() const noexcept { return descriptor_; }

 private:
  const int descriptor_;
};

// The low half of the state, on which the kernel lets threads of different processes wait.
std::uint32_t* futex_word(std::atomic<std::uint64_t>& state) {
  static_assert(std::endian::native == std::endian::little);
  return reinterpret_cast<std::uint32_t*>(&state);
}

void wake_all(std::atomic<std::uint64_t>& state) {
  syscall(SYS_futex, futex_word(state), FUTEX_WAKE, std::numeric_limits<int>::max(), nullptr,
          nullptr, 0);
}

// Returns also when it was woken for nothing.
void wait_while(std::atomic<std::uint64_t>& state, std::uint64_t seen,
                std::chrono::nanoseconds at_most) {
  const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(at_most);
  const timespec timeout{.tv_sec = static_cast<time_t>(seconds.count()),
                         .tv_nsec = static_cast<long>((at_most - seconds).count())};
  syscall(SYS_futex, futex_word(state), FUTEX_WAIT, static_cast<std::uint32_t>(seen), &timeout,
          nullptr, 0);
}

template <class T>
void put(std::byte*& position, const T& value) {
  std::memcpy(position, &value, sizeof value);
  position += sizeof value;
}

template <class T>
void get(const std::byte*& position, T& value) {
  std::memcpy(&value, position, sizeof value);
  position += sizeof value;
}

}  // namespace

void encode(const PayloadReference& reference, std::span<std::byte, kReferenceBytes> payload) {
  std::byte* position = payload.data();
  put(position, kEncapsulation);
  put(position, reference.participant);
  put(position, reference.block);
  put(position, reference.sequence);
  put(position, reference.bytes);
}

std::optional<PayloadReference> decode_reference(std::span<const std::byte> payload) {
  if (payload.size() != kReferenceBytes ||
      !std::equal(kEncapsulation.begin(), kEncapsulation.end(), payload.begin())) {
    return std::nullopt;
  }
  PayloadReference reference;
  const std::byte* position = payload.data() + kEncapsulation.size();
  get(position, reference.participant);
  get(position, reference.block);
  get(position, reference.sequence);
  get(position, reference.bytes);
  return reference;
}

std::optional<std::string> payload_scope(const std::filesystem::path& folder) {
  struct stat memory {};
  struct stat users {};
  std::string boot;
  std::ifstream("/proc/sys/kernel/random/boot_id") >> boot;
  if (stat(folder.c_str(), &memory) != 0 || stat("/proc/self/ns/user", &users) != 0 ||
      boot.empty()) {
    return std::nullopt;
  }
  constexpr int kLayout = 1;
  return boot + "/" + std::to_string(memory.st_dev) + "/" + std::to_string(users.st_ino) + "/" +
         std::to_string(geteuid()) + "/" + std::to_string(kLayout);
}

/// One block as its writer has it.
class PayloadWriter::Block {
 public:
  /// Nothing when there is no room.
  static std::unique_ptr<Block> create(PayloadFolder& folder, std::size_t capacity) {
    const std::uint32_t number = folder.next_block();
    const std::filesystem::path file = folder.path() / file_name(folder.participant(), number);
    auto descriptor = std::make_unique<FileDescriptor>(
        open(file.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0600));
    if (descriptor->get() < 0) {
      return nullptr;
    }
    // The lock says that the owner lives. The pages are taken now: later there might be none, which
    // would end the process.
    void* memory = MAP_FAILED;
    const std::size_t size = kPage + capacity;
    if (flock(descriptor->get(), LOCK_EX | LOCK_NB) == 0 &&
        posix_fallocate(descriptor->get(), 0, static_cast<off_t>(size)) == 0) {
      memory = mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_POPULATE,
                    descriptor->get(), 0);
    }
    if (memory == MAP_FAILED) {
      unlink(file.c_str());
      return nullptr;
    }
    return std::make_unique<Block>(number, file, std::move(descriptor),
                                   static_cast<std::byte*>(memory), capacity);
  }
  Block(std::uint32_t number, std::filesystem::path file, std::unique_ptr<FileDescriptor> lock,
        std::byte* memory, std::size_t capacity)
      : number_(number),
        file_(std::move(file)),
        lock_(std::move(lock)),
        memory_(memory),
        capacity_(capacity),
        header_(new (memory) BlockHeader) {}
  Block(const Block&) = delete;
  Block& operator=(const Block&) = delete;
  ~Block() {
    header_->retired.store(1);
    unlink(file_.c_str());
    munmap(memory_, kPage + capacity_);
  }

  [[nodiscard]] std::uint32_t number() const noexcept { return number_; }
  [[nodiscard]] std::span<std::byte> data(std::size_t bytes) const {
    return {memory_ + kPage, bytes};
  }
  [[nodiscard]] std::size_t capacity() const noexcept { return capacity_; }
  [[nodiscard]] std::atomic<std::uint64_t>& state() const noexcept { return header_->state; }
  [[nodiscard]] bool is_taken() const noexcept {
    return (header_->state.load(std::memory_order_acquire) & kReaderMask) == 0;
  }

 private:
  const std::uint32_t number_;
  const std::filesystem::path file_;
  const std::unique_ptr<FileDescriptor> lock_;
  std::byte* const memory_;
  const std::size_t capacity_;
  BlockHeader* const header_;
};

PayloadWriter::PayloadWriter(std::shared_ptr<PayloadFolder> folder, std::size_t depth)
    : folder_(std::move(folder)), depth_(depth) {}

PayloadWriter::~PayloadWriter() = default;

std::optional<PayloadReference> PayloadWriter::store(
    std::size_t bytes, std::size_t readers, const std::function<bool(std::span<std::byte>)>& fill) {
  if (bytes > std::numeric_limits<std::uint32_t>::max() || readers > kReaderMask) {
    return std::nullopt;
  }
  const std::lock_guard lock(mutex_);
  Block* const block = free_block(bytes);
  if (block == nullptr) {
    return std::nullopt;
  }
  std::erase(history_, block);
  block->state().store(0, std::memory_order_relaxed);
  // A reader that still reads sees the state change no later than the first new byte.
  std::atomic_thread_fence(std::memory_order_seq_cst);
  if (!fill(block->data(bytes))) {
    return std::nullopt;
  }
  const std::uint64_t sequence = ++last_sequence_;
  block->state().store(sequence << kReaderBits | readers, std::memory_order_release);
  history_.push_back(block);
  if (history_.size() > depth_) {
    history_.pop_front();
  }
  return PayloadReference{.participant = folder_->participant(),
                          .block = block->number(),
                          .sequence = sequence,
                          .bytes = static_cast<std::uint32_t>(bytes)};
}

PayloadWriter::Block* PayloadWriter::free_block(std::size_t bytes) {
  const auto is_free = [this](const Block& block) {
    return block.is_taken() ||
           std::find(history_.begin(), history_.end(), &block) == history_.end();
  };
  for (const auto& block : blocks_) {
    if (block->capacity() >= bytes && is_free(*block)) {
      return block.get();
    }
  }
  // What is free is too small.
  std::erase_if(blocks_, [&](const std::unique_ptr<Block>& block) {
    if (!is_free(*block)) {
      return false;
    }
    std::erase(history_, block.get());
    return true;
  });
  return add_block(bytes);
}

PayloadWriter::Block* PayloadWriter::add_block(std::size_t bytes) {
  const std::size_t capacity = (bytes + bytes / kSlackShare + kPage - 1) / kPage * kPage;
  std::error_code error;
  const auto room = std::filesystem::space(folder_->path(), error).available;
  auto block =
      !error && room / kRoomShare >= capacity ? Block::create(*folder_, capacity) : nullptr;
  if (block == nullptr) {
    folder_->warnings().add(
        "no space in " + folder_->path().string() +
        " for large messages to other processes of this machine: they are sent in fragments, which "
        "takes several times as long; make it larger (docker run --shm-size=...)");
    return nullptr;
  }
  return blocks_.emplace_back(std::move(block)).get();
}

void PayloadWriter::await_readers(std::chrono::milliseconds at_most) {
  const auto until = std::chrono::steady_clock::now() + at_most;
  const std::lock_guard lock(mutex_);
  for (Block* const block : history_) {
    for (;;) {
      const std::uint64_t seen = block->state().load(std::memory_order_acquire);
      const auto left = until - std::chrono::steady_clock::now();
      if ((seen & kReaderMask) == 0 || left <= left.zero()) {
        break;
      }
      wait_while(block->state(), seen, left);
    }
  }
}

/// A block as a reader has it.
class PayloadReader::Mapping {
 public:
  static std::shared_ptr<Mapping> open_file(const std::filesystem::path& file) {
    const FileDescriptor descriptor(open(file.c_str(), O_RDWR | O_CLOEXEC));
    struct stat status {};
    if (descriptor.get() < 0 || fstat(descriptor.get(), &status) != 0 ||
        status.st_size <= static_cast<off_t>(kPage)) {
      return nullptr;
    }
    auto mapping = std::make_shared<Mapping>();
    const std::size_t capacity = static_cast<std::size_t>(status.st_size) - kPage;
    void* header = mmap(nullptr, kPage, PROT_READ | PROT_WRITE, MAP_SHARED, descriptor.get(), 0);
    if (header == MAP_FAILED) {
      return nullptr;
    }
    mapping->header_ = static_cast<BlockHeader*>(header);
    void* data = mmap(nullptr, capacity, PROT_READ, MAP_SHARED | MAP_POPULATE, descriptor.get(),
                      static_cast<off_t>(kPage));
    if (data == MAP_FAILED) {
      return nullptr;
    }
    mapping->data_ = {static_cast<const std::byte*>(data), capacity};
    return mapping;
  }
  Mapping() = default;
  Mapping(const Mapping&) = delete;
  Mapping& operator=(const Mapping&) = delete;
  ~Mapping() {
    if (!data_.empty()) {
      munmap(const_cast<std::byte*>(data_.data()), data_.size());
    }
    if (header_ != nullptr) {
      munmap(header_, kPage);
    }
  }

  [[nodiscard]] std::span<const std::byte> data() const noexcept { return data_; }
  [[nodiscard]] std::atomic<std::uint64_t>& state() const noexcept { return header_->state; }
  [[nodiscard]] bool is_retired() const noexcept { return header_->retired.load() != 0; }

 private:
  BlockHeader* header_ = nullptr;
  std::span<const std::byte> data_;
};

PayloadReader::PayloadReader(std::filesystem::path folder) : folder_(std::move(folder)) {}

PayloadReader::~PayloadReader() = default;

std::shared_ptr<PayloadReader::Mapping> PayloadReader::mapping(const Key& key) {
  const std::lock_guard lock(mutex_);
  const auto known = mappings_.find(key);
  if (known != mappings_.end()) {
    return known->second;
  }
  std::erase_if(mappings_, [](const auto& entry) { return entry.second->is_retired(); });
  auto mapping = Mapping::open_file(folder_ / file_name(key.first, key.second));
  if (mapping) {
    mappings_.emplace(key, mapping);
  }
  return mapping;
}

bool PayloadReader::take(const PayloadReference& reference,
                         const std::function<void(std::span<const std::byte>)>& read) {
  const auto block = mapping({reference.participant, reference.block});
  if (!block || reference.bytes > block->data().size()) {
    return false;
  }
  auto& state = block->state();
  if (state.load(std::memory_order_acquire) >> kReaderBits != reference.sequence) {
    return false;
  }
  read(block->data().first(reference.bytes));
  std::atomic_thread_fence(std::memory_order_seq_cst);
  std::uint64_t seen = state.load(std::memory_order_acquire);
  for (;;) {
    if (seen >> kReaderBits != reference.sequence) {
      return false;
    }
    if ((seen & kReaderMask) == 0) {
      return true;
    }
    if (state.compare_exchange_weak(seen, seen - 1, std::memory_order_acq_rel)) {
      break;
    }
  }
  if ((seen & kReaderMask) == 1) {
    wake_all(state);
  }
  return true;
}

void PayloadReader::forget(const GuidPrefix& participant) {
  const std::lock_guard lock(mutex_);
  std::erase_if(mappings_, [&](const auto& entry) { return entry.first.first == participant; });
}

}  // namespace pipescout::dds
