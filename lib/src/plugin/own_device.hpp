// Devices in C: conversion of measurements, and an EnamelDevice as a HapticDevice.
#pragma once

#include <algorithm>
#include <memory>

#include "enamel/device/haptic_device.hpp"
#include "enamel/plugin/driver.h"
#include "plugin/convert.hpp"

namespace enamel {

/// Return whether a struct was initialised for this library.
template <typename Struct>
bool isKnown(const Struct& given) noexcept {
  return given.size == sizeof(Struct);
}

inline Status statusOf(std::int32_t result) noexcept {
  return result >= ENAMEL_OK && result <= ENAMEL_INACTIVE ? static_cast<Status>(result) : Status::inactive;
}

inline Measurement measurementOf(const EnamelMeasurement& in, int joints) noexcept {
  Measurement out;
  out.time = in.time;
  fromPlain(in.q, joints, out.q);
  fromPlain(in.rates, joints, out.rates);
  if (in.applied_known != 0) fromPlain(in.applied, joints, out.applied.emplace());
  out.enabled = in.enabled != 0;
  out.buttons = in.buttons;
  if (in.has_gripper != 0) out.gripper = in.gripper;
  out.conditions = in.conditions;
  out.heat = in.heat;
  out.failed = in.failed != 0;
  out.age = out.failed ? std::max(in.age, std::int32_t{1}) : in.age;
  return out;
}

inline void toPlain(const Measurement& in, EnamelMeasurement& out) noexcept {
  out = EnamelMeasurement{};
  out.size = sizeof out;
  out.age = in.age;
  out.time = in.time;
  toPlain(in.q, out.q);
  toPlain(in.rates, out.rates);
  if (in.applied) toPlain(*in.applied, out.applied);
  out.applied_known = in.applied ? 1 : 0;
  out.gripper = in.gripper.value_or(0.0);
  out.has_gripper = in.gripper ? 1 : 0;
  out.enabled = in.enabled ? 1 : 0;
  out.failed = in.failed ? 1 : 0;
  out.buttons = in.buttons;
  out.conditions = in.conditions;
  out.heat = in.heat;
}

/// Make a HapticDevice of a table in C. Throws Error if its size is wrong, or measure or actuate is missing.
std::unique_ptr<HapticDevice> makeDevice(const EnamelDevice& device, int joints);

}  // namespace enamel
