#include "runner.hpp"

#include <algorithm>

namespace enamel::viewer {

PairSample pairOf(const TickRecord& left, const TickRecord& right) noexcept {
  const auto sideOf = [](const TickRecord& record) -> PairSample::Side {
    return {-record.nearest.gap, deliveredOf(record).normal};
  };
  return {{sideOf(left), sideOf(right)}};
}

Runner::Runner(std::unique_ptr<Experiment> experiment) : experiment_(experiment.release()) {
  experiment_->look();
  frames_.next().first = experiment_->frame();
  frames_.publish();
}

// The haptic side has ended before.
Runner::~Runner() {
  collect();
  RunnerCommand command;
  while (commands_.pop(command)) {
    delete command.experiment;
    delete command.second;
  }
  delete experiment_;
  delete second_;
}

void Runner::replace(std::unique_ptr<Experiment> experiment, std::unique_ptr<Experiment> second) {
  collect();
  RunnerCommand command{RunnerCommand::Kind::replace};
  command.experiment = experiment.get();
  command.second = second.get();
  if (!commands_.push(command)) return;
  experiment.release();
  second.release();
}

void Runner::collect() noexcept {
  for (Experiment* old = nullptr; retired_.pop(old);) delete old;
}

const Frame& Runner::frame() noexcept {
  frames_.refresh();
  return frames_.latest().first;
}

void Runner::obey(const RunnerCommand& command) noexcept {
  switch (command.kind) {
    case RunnerCommand::Kind::handTo: experiment_->moveHandTo(command.target); break;
    case RunnerCommand::Kind::handBy: experiment_->moveHandBy(command.target); break;
    case RunnerCommand::Kind::select: experiment_->select(static_cast<RendererSlot>(command.number)); break;
    case RunnerCommand::Kind::selectRight:
      if (second_ != nullptr) second_->select(static_cast<RendererSlot>(command.number));
      break;
    case RunnerCommand::Kind::grip: experiment_->setGrip(command.grip); break;
    case RunnerCommand::Kind::testPush:
      experiment_->startTestPush();
      if (second_ != nullptr) second_->startTestPush();
      break;
    case RunnerCommand::Kind::spin: experiment_->spin(command.number != 0); break;
    case RunnerCommand::Kind::undo: experiment_->undo(); break;
    case RunnerCommand::Kind::restore: experiment_->restore(); break;
    case RunnerCommand::Kind::pause: paused_ = true; break;
    case RunnerCommand::Kind::resume: paused_ = false; break;
    case RunnerCommand::Kind::step: steps_ += command.number; break;
    case RunnerCommand::Kind::slowdown: slowdown_ = std::clamp(command.number, 1, 1000); break;
    case RunnerCommand::Kind::replace: {
      // Never full: replace() empties this ring, which is twice as large as that of the commands.
      (void)retired_.push(experiment_);
      if (second_ != nullptr) (void)retired_.push(second_);
      experiment_ = command.experiment;
      second_ = command.second;
      experiment_->look();
      if (second_ != nullptr) second_->look();
      break;
    }
  }
}

void Runner::tick() noexcept {
  if (second_ != nullptr)
    Experiment::tickTogether(*experiment_, *second_);
  else
    experiment_->tick();
  if (experiment_->frame().plant != Status::ok) return;
  if (second_ != nullptr) {
    if (second_->frame().plant != Status::ok) return;
    if (!pairs_.push(pairOf(experiment_->frame().record, second_->frame().record))) ++dropped_;
  }
  if (!samples_.push(sampleOf(experiment_->frame().record))) ++dropped_;
}

void Runner::period() noexcept {
  for (RunnerCommand command; commands_.pop(command);) obey(command);
  if (paused_) {
    for (; steps_ > 0; --steps_) tick();
  } else {
    steps_ = 0;
    if (++waited_ >= slowdown_) {
      waited_ = 0;
      tick();
    }
  }
  experiment_->publish();
  Frames& frames = frames_.next();
  frames.pair = second_ != nullptr;
  if (second_ != nullptr) frames.second = second_->frame();
  Frame& frame = frames.first;
  frame = experiment_->frame();
  frame.paused = paused_;
  frame.slowdown = slowdown_;
  frame.droppedSamples = dropped_;
  frames_.publish();
}

}  // namespace enamel::viewer
