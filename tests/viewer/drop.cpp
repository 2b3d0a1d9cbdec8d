// Drops a file on a window as a file manager would: drop WINDOW FILE. It uses XDND version 5 towards GLFW. Exits with 1
// if the window does not accept the file. (GLFW 3.3.8 answers with the length of the data instead of the protocol's one
// bit.)
#include <X11/Xatom.h>
#include <X11/Xlib.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <thread>

namespace {

struct Source {
  Display* display = XOpenDisplay(nullptr);
  Window target, own;
  std::string uri;

  Atom atom(const char* name) const { return XInternAtom(display, name, False); }

  void tell(const char* type, long a, long b, long c, long d) const {
    XEvent event{};
    event.xclient.type = ClientMessage;
    event.xclient.window = target;
    event.xclient.message_type = atom(type);
    event.xclient.format = 32;
    const long data[] = {static_cast<long>(own), a, b, c, d};
    std::copy(data, data + 5, event.xclient.data.l);
    XSendEvent(display, target, False, NoEventMask, &event);
    XFlush(display);
  }

  void give(const XSelectionRequestEvent& request) const {
    XChangeProperty(display, request.requestor, request.property, request.target, 8, PropModeReplace,
                    reinterpret_cast<const unsigned char*>(uri.data()), static_cast<int>(uri.size()));
    XEvent answer{};
    answer.xselection.type = SelectionNotify;
    answer.xselection.requestor = request.requestor;
    answer.xselection.selection = request.selection;
    answer.xselection.target = request.target;
    answer.xselection.property = request.property;
    answer.xselection.time = request.time;
    XSendEvent(display, request.requestor, False, NoEventMask, &answer);
    XFlush(display);
  }

  // Serve the selection until a message of that type arrives. Return its answer, l[1].
  bool waitFor(const char* type, long& answer) const {
    const auto end = std::chrono::steady_clock::now() + std::chrono::minutes(15);
    while (std::chrono::steady_clock::now() < end) {
      while (XPending(display) > 0) {
        XEvent event;
        XNextEvent(display, &event);
        if (event.type == SelectionRequest) give(event.xselectionrequest);
        if (event.type == ClientMessage && event.xclient.message_type == atom(type)) {
          answer = event.xclient.data.l[1];
          return true;
        }
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return false;
  }
};

}  // namespace

int main(int argc, char** argv) {
  Source source;
  if (argc != 3 || source.display == nullptr) return 2;
  source.target = std::strtoul(argv[1], nullptr, 0);
  source.uri = std::string("file://") + argv[2] + "\r\n";
  source.own = XCreateSimpleWindow(source.display, DefaultRootWindow(source.display), 0, 0, 1, 1, 0, 0, 0);
  XSetSelectionOwner(source.display, source.atom("XdndSelection"), source.own, CurrentTime);
  constexpr long version = 5, somewhere = 300 << 16 | 300;
  long answer = 0;
  source.tell("XdndEnter", version << 24, static_cast<long>(source.atom("text/uri-list")), 0, 0);
  source.tell("XdndPosition", 0, somewhere, CurrentTime, static_cast<long>(source.atom("XdndActionCopy")));
  if (!source.waitFor("XdndStatus", answer) || (answer & 1) == 0) return 1;
  source.tell("XdndDrop", 0, CurrentTime, 0, 0);
  return source.waitFor("XdndFinished", answer) && answer != 0 ? 0 : 1;
}
