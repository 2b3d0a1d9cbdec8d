// A disk in memory with limited space, for a Recorder's thread.
#pragma once

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <mutex>
#include <string>

namespace enamel::test {

class Disk {
 public:
  explicit Disk(std::size_t room) : room_(room) {}

  /// Write as write(2) does on a full disk.
  std::size_t write(const char* bytes, std::size_t size) {
    const std::lock_guard<std::mutex> lock(mutex_);
    const std::size_t now = std::min(size, room_ - content_.size());
    content_.append(bytes, now);
    errno = ENOSPC;
    return now;
  }
  void setRoom(std::size_t room) {
    const std::lock_guard<std::mutex> lock(mutex_);
    room_ = room;
  }
  std::string content() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return content_;
  }

 private:
  mutable std::mutex mutex_;
  std::size_t room_;
  std::string content_;
};

}  // namespace enamel::test
