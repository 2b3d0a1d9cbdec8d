// File format of recordings: lib/docs/recording.md.
#pragma once

#include <cstdint>
#include <cstring>
#include <string>

#include "enamel/runtime/recording.hpp"

namespace enamel::recording {

static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "numbers are copied as they are: little-endian");

inline constexpr char kMagic[8] = {'E', 'N', 'A', 'M', 'E', 'L', 'R', '\n'};
inline constexpr std::uint32_t kVersion = 2;
inline constexpr std::size_t kPreamble = 24;  // magic, version, length of the header, its CRC-32, 0
inline constexpr std::size_t kLargestHeader = std::size_t{4} << 20, kLargestState = std::size_t{1} << 20;

inline constexpr std::uint32_t kChunkMark = 0x4b4e4843;  // "CHNK"
inline constexpr std::uint32_t kFresh = 1, kLast = 2;

struct ChunkHead {
  std::uint32_t mark = kChunkMark, crc = 0;  // of everything after it in the chunk
  std::uint64_t sequence = 0, lost = 0;
  std::uint32_t ticks = 0, flags = 0;
};
static_assert(sizeof(ChunkHead) == 32);

struct TickBytes {
  std::uint64_t number;
  double time;
  double q[kMaxJoints], rates[kMaxJoints], applied[kMaxJoints];  // zero past their sizes
  double requested[kMaxJoints], command[kMaxJoints];             // zero past the device's joints
  double normalForce;
  std::uint64_t stateHash;
  std::uint8_t sizes[3];                          // of q, rates, applied
  std::uint8_t status, reason, mode, flags, age;  // age of the sample, at most 255 periods
  double gripper, heat;                           // gripper: NaN without one
  std::uint32_t buttons, conditions;
};
static_assert(sizeof(TickBytes) == 344);
inline constexpr std::size_t kFirstTickBytes = 320;  // of version 1: without gripper and all after it
inline constexpr std::uint8_t kEnabled = 1, kSaturated = 2, kReset = 4, kSpins = 8, kFailed = 16;

inline constexpr std::size_t kChunkCrcBegin = 8;  // after mark and CRC
inline std::size_t padded(std::size_t size) noexcept { return (size + 7) / 8 * 8; }

/// Return a hash: eight sums of words and eight sums of those sums (after Fletcher, 1982), folded by FNV-1a. The rest
/// of the last 64 bytes is zero. It needs additions only; the state of a servo takes 0.1 us.
inline std::uint64_t hashOf(const char* bytes, std::size_t size) noexcept {
  constexpr std::size_t kLanes = 8, kBlock = 8 * kLanes;
  std::uint64_t sum[kLanes] = {}, sums[kLanes] = {}, words[kLanes] = {};
  const auto add = [&] {
    for (std::size_t i = 0; i < kLanes; ++i) sums[i] += sum[i] += words[i];
  };
  std::size_t at = 0;
  for (; at + kBlock <= size; at += kBlock) {
    std::memcpy(words, bytes + at, kBlock);
    add();
  }
  std::memset(words, 0, kBlock);
  std::memcpy(words, bytes + at, size - at);
  add();
  std::uint64_t hash = 0xcbf29ce484222325;
  for (std::size_t i = 0; i < kLanes; ++i)
    for (const std::uint64_t word : {sum[i], sums[i]}) hash = (hash ^ word) * 0x100000001b3;
  return hash;
}

std::string headerText(const RecordingHeader& header);
RecordingHeader parseHeader(const std::string& text, const std::string& file);

}  // namespace enamel::recording
