// Shared by tests of drivers: a device is unplugged while its session is in contact with a wall.
#pragma once

#include <functional>
#include <string>

#include "enamel/session/session.hpp"
#include "support/catch.hpp"
#include "support/eventually.hpp"

namespace enamel::test {

/// A session with the device of a URL must feel a wall at `wall` (z, m). It must ramp out when `unplug(true)` takes the
/// device away, and name the loss. After `unplug(false)` it must come back only by a reset. `force`: that the stand-in
/// receives, N.
inline void checkUnpluggedInContact(const std::string& url, const std::string& pluginFolder, double wall,
                                    const std::function<void(bool)>& unplug, const std::function<double()>& force) {
  SessionDef def;
  def.device = url;
  def.pluginFolder = pluginFolder;
  Session session(def);
  Obstacle obstacle = flatWall().obstacles()[0];
  obstacle.pose.position.z() = wall;
  (void)session.add({obstacle});
  int lost = 0, back = 0;
  const auto take = [&] {
    for (SessionEvent event; session.nextEvent(event);) {
      lost += event.kind == EventKind::deviceLost ? 1 : 0;
      back += event.kind == EventKind::deviceBack ? 1 : 0;
    }
  };
  // On a busy machine a tick may come late. Then start again.
  const auto touches = [&] {
    if (session.snapshot().fault != GuardReason::none) session.reset();
    const Snapshot now = session.snapshot();
    return now.tick.mode == RenderMode::contact && now.fault == GuardReason::none && force() > 0.1;
  };
  session.startOpened();
  REQUIRE(eventually(touches));
  take();
  lost = back = 0;
  unplug(true);
  REQUIRE(eventually([&] {
    take();
    return lost > 0;
  }));
  CHECK(session.snapshot().fault != GuardReason::none);
  CHECK(eventually([&] { return session.snapshot().tick.command.effort.isZero(1e-12) && force() == 0.0; }));
  unplug(false);
  REQUIRE(eventually([&] {
    take();
    return back > 0;
  }));
  // It comes back only after a reset.
  for (int i = 0; i < 100; ++i) {
    CHECK(session.snapshot().fault != GuardReason::none);
    CHECK(force() == 0.0);
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  CHECK(eventually(touches));
  session.stop();
}

}  // namespace enamel::test
