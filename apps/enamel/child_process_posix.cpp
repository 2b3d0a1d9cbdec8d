#include <fcntl.h>
#include <fmt/core.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstring>

#include "child_process.hpp"
#include "enamel/core/error.hpp"

namespace enamel::app {
namespace {

constexpr char kAnswered = 'A', kFailed = 'F';  // first byte of the child's message

[[noreturn]] void answer(int pipe, const std::string& what, double seconds, const std::function<std::string()>& work) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  const auto whole = static_cast<rlim_t>(std::ceil(seconds));
  const rlimit computing{whole, whole + 1};
  setrlimit(RLIMIT_CPU, &computing);
  std::string message;
  try {
    message = kAnswered + work();
  } catch (const Error& error) {
    message = kFailed + std::string(error.what());
  } catch (const std::exception& error) {
    message = kFailed + what + " threw: " + error.what();
  } catch (...) {
    message = kFailed + what + " threw an unknown exception";
  }
  std::fflush(nullptr);
  for (std::size_t sent = 0; sent < message.size();) {
    const ssize_t n = write(pipe, message.data() + sent, message.size() - sent);
    if (n > 0) sent += static_cast<std::size_t>(n);
    if (n < 0 && errno != EINTR) break;
  }
  _exit(0);
}

// Append everything that is in the pipe.
void drain(int pipe, std::string& message) {
  std::array<char, 4096> buffer;
  for (ssize_t n = 0; (n = read(pipe, buffer.data(), buffer.size())) > 0;)
    message.append(buffer.data(), static_cast<std::size_t>(n));
}

std::string endOf(int status, bool late, double seconds) {
  if (late) return fmt::format("did not end in {:.3g} s", 3 * seconds);
  if (!WIFSIGNALED(status)) return fmt::format("ended the process with exit status {}", WEXITSTATUS(status));
  if (WTERMSIG(status) == SIGXCPU) return fmt::format("computed for longer than {:.3g} s", seconds);
  return fmt::format("ended in a crash ({})", strsignal(WTERMSIG(status)));
}

}  // namespace

ChildResult runInChild(const std::string& what, double seconds, const std::function<std::string()>& work) {
  using Clock = std::chrono::steady_clock;
  std::array<int, 2> ends{};
  std::fflush(nullptr);
  if (pipe2(ends.data(), O_CLOEXEC | O_NONBLOCK) != 0)
    throw Error(std::string("cannot make a pipe: ") + std::strerror(errno));
  const auto deadline = Clock::now() + std::chrono::milliseconds(static_cast<long>(3e3 * seconds));
  const pid_t child = fork();
  if (child == 0) {
    close(ends[0]);
    fcntl(ends[1], F_SETFL, 0);  // block on a full pipe: the child waits for room
    answer(ends[1], what, seconds, work);
  }
  const int problem = errno;
  close(ends[1]);
  std::string message;
  int status = 0;
  bool late = false;
  // A closed pipe does not mean that the child has ended: it may close the pipe early, or its own children may keep it
  // open.
  while (child > 0 && waitpid(child, &status, WNOHANG) == 0) {
    pollfd readable{ends[0], POLLIN, 0};
    poll(&readable, 1, 10);
    drain(ends[0], message);
    if ((readable.revents & POLLHUP) != 0) usleep(500);
    if (late || Clock::now() < deadline) continue;
    late = true;
    kill(child, SIGKILL);
  }
  drain(ends[0], message);
  close(ends[0]);
  if (child < 0) throw Error(std::string("cannot start a process: ") + std::strerror(problem));
  if (message.empty() || status != 0) return {"", what + " " + endOf(status, late, seconds)};
  const std::string text = message.substr(1);
  return message[0] == kAnswered ? ChildResult{text, ""} : ChildResult{"", printable(text)};
}

}  // namespace enamel::app
