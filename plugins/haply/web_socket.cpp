#include "web_socket.hpp"

// The tick's thread runs the handlers. No other thread exists, so the locks are left out.
#define BOOST_ASIO_DISABLE_THREADS
#include <boost/asio/connect.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core/flat_static_buffer.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>
#include <cstring>
#include <new>
#include <stdexcept>
#include <utility>

namespace enamel::haply {
namespace {

namespace net = boost::asio;
namespace websocket = boost::beast::websocket;
using Code = boost::system::error_code;
// With an executor of a fixed type: the usual polymorphic one allocates.
using Socket = net::basic_stream_socket<net::ip::tcp, net::io_context::executor_type>;

constexpr std::chrono::seconds kLongestWait{2};  // of connecting and upgrading
constexpr std::size_t kLargestMessage = 65536;   // bytes, of the service; it sends some hundred to some thousand
constexpr int kMostHandlers = 256;               // in one call, so that a flood cannot hold the tick

// Memory for the operations that are under way: a read, a write, and their inner steps.
class Blocks {
 public:
  void* take(std::size_t size) {
    for (Block& block : blocks_)
      if (!block.isUsed && size <= sizeof block.bytes) return block.isUsed = true, block.bytes;
    throw std::bad_alloc();
  }
  void give(void* bytes) noexcept {
    for (Block& block : blocks_)
      if (block.bytes == bytes) block.isUsed = false;
  }

 private:
  struct Block {
    alignas(std::max_align_t) unsigned char bytes[2048];
    bool isUsed = false;
  };
  std::array<Block, 16> blocks_;
};

template <typename T>
struct BlockAllocator {
  using value_type = T;
  Blocks* blocks;

  explicit BlockAllocator(Blocks& b) noexcept : blocks(&b) {}
  template <typename U>
  BlockAllocator(const BlockAllocator<U>& other) noexcept : blocks(other.blocks) {}
  T* allocate(std::size_t n) { return static_cast<T*>(blocks->take(n * sizeof(T))); }
  void deallocate(T* bytes, std::size_t) noexcept { blocks->give(bytes); }
  template <typename U>
  bool operator==(const BlockAllocator<U>& other) const noexcept {
    return blocks == other.blocks;
  }
  template <typename U>
  bool operator!=(const BlockAllocator<U>& other) const noexcept {
    return blocks != other.blocks;
  }
};

// A handler whose operations live in the blocks.
template <typename Function>
struct Handler {
  using allocator_type = BlockAllocator<void>;
  Blocks* blocks;
  Function function;

  allocator_type get_allocator() const noexcept { return allocator_type(*blocks); }
  void operator()(Code error, std::size_t size) { function(error, size); }
};

}  // namespace

struct WebSocket::Impl {
  net::io_context io{BOOST_ASIO_CONCURRENCY_HINT_UNSAFE};
  websocket::stream<Socket> stream{io};
  Blocks blocks;
  boost::beast::flat_static_buffer<kLargestMessage> incoming;
  std::array<char, kLargestMessage> message{};
  std::array<char, 512> outgoing{};
  std::size_t size = 0, arrived = 0;
  bool isWriting = false, isLost = false;

  template <typename Function>
  auto handler(Function function) noexcept {
    return Handler<Function>{&blocks, function};
  }

  void read() {
    stream.async_read(incoming, handler([this](Code error, std::size_t bytes) {
                        if (error) return void(isLost = true);
                        std::memcpy(message.data(), incoming.data().data(), bytes);
                        size = bytes;
                        ++arrived;
                        incoming.consume(bytes);
                        read();
                      }));
  }

  // Run handlers until `isDone` or the limit.
  void await(const bool& isDone, const Code& error, const char* what) {
    const auto limit = std::chrono::steady_clock::now() + kLongestWait;
    io.restart();
    while (!isDone && io.run_one_until(limit) > 0) {
    }
    const std::string reason = !isDone ? "no answer within 2 s" : error.message();
    if (!isDone || error)
      throw std::runtime_error(std::string(what) + ": " + reason +
                               "; is this the Haply Inverse service, and does it run?");
  }
};

WebSocket::WebSocket(const std::string& host, const std::string& port) : impl_(std::make_unique<Impl>()) {
  Impl& s = *impl_;
  const std::string where = host + ":" + port;
  Code error;
  net::ip::tcp::resolver resolver(s.io);
  const auto found = resolver.resolve(host, port, error);
  if (error) throw std::runtime_error(where + ": " + error.message());
  bool isDone = false;
  net::async_connect(s.stream.next_layer(), found, [&](Code result, const net::ip::tcp::endpoint&) {
    error = result;
    isDone = true;
  });
  s.await(isDone, error, where.c_str());
  s.stream.next_layer().set_option(net::ip::tcp::no_delay(true));
  s.stream.read_message_max(kLargestMessage);
  s.stream.auto_fragment(false);
  s.stream.text(true);
  isDone = false;
  s.stream.async_handshake(where, "/", [&](Code result) {
    error = result;
    isDone = true;
  });
  s.await(isDone, error, where.c_str());
  s.read();
}

WebSocket::~WebSocket() {
  Code ignored;
  impl_->stream.next_layer().close(ignored);
  impl_->io.restart();
  impl_->io.poll(ignored);  // the cancelled operations give their memory back
}

std::string_view WebSocket::receive(std::size_t& count) noexcept {
  Impl& s = *impl_;
  try {
    s.io.restart();
    for (int i = 0; i < kMostHandlers && s.io.poll_one() > 0; ++i) {
    }
  } catch (...) {
    s.isLost = true;
  }
  const std::size_t arrived = std::exchange(s.arrived, 0);  // send() receives as well
  count += arrived;
  return arrived > 0 ? std::string_view(s.message.data(), s.size) : std::string_view();
}

bool WebSocket::send(std::string_view text) noexcept {
  Impl& s = *impl_;
  if (s.isLost || s.isWriting || text.size() > s.outgoing.size()) return false;
  std::memcpy(s.outgoing.data(), text.data(), text.size());
  s.isWriting = true;
  try {
    s.stream.async_write(net::buffer(s.outgoing.data(), text.size()), s.handler([&s](Code error, std::size_t) {
      s.isWriting = false;
      if (error) s.isLost = true;
    }));
    s.io.restart();
    for (int i = 0; i < kMostHandlers && s.isWriting && s.io.poll_one() > 0; ++i) {
    }
  } catch (...) {
    s.isLost = true;
  }
  return !s.isLost;
}

bool WebSocket::isLost() const noexcept { return impl_->isLost; }

}  // namespace enamel::haply
