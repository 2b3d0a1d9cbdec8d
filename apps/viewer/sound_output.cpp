#include "sound_output.hpp"

#ifdef ENAMEL_OPENAL
#include <al.h>
#include <alc.h>
#include <alext.h>
#include <pthread.h>

#include <array>
#include <chrono>
#include <memory>
#endif

namespace enamel::viewer {

SoundOutput::SoundOutput() : thread_(&SoundOutput::run, this) {}

SoundOutput::~SoundOutput() {
  stop_.store(true, std::memory_order_relaxed);
  thread_.join();
}

void SoundOutput::set(const BurLoad& load) noexcept {
  load_.next() = load;
  load_.publish();
}

void SoundOutput::run() noexcept { trouble_.store(play(), std::memory_order_relaxed); }

#ifdef ENAMEL_OPENAL

const char* SoundOutput::play() noexcept {
  constexpr std::size_t blocks = 4, length = 512;  // samples: 12 ms each
  pthread_setname_np(pthread_self(), "sound");
  const auto close = [](ALCdevice* device) { alcCloseDevice(device); };
  const std::unique_ptr<ALCdevice, decltype(close)> device(alcOpenDevice(nullptr), close);
  if (!device) return "no audio device";
  const auto end = [](ALCcontext* context) {
    alcMakeContextCurrent(nullptr);
    alcDestroyContext(context);
  };
  const std::unique_ptr<ALCcontext, decltype(end)> context(alcCreateContext(device.get(), nullptr), end);
  if (!context || alcMakeContextCurrent(context.get()) == ALC_FALSE) return "the audio device does not play";
  ALuint source = 0;
  std::array<ALuint, blocks> buffers{};
  alGenSources(1, &source);
  alGenBuffers(blocks, buffers.data());
  BurSound sound;
  const auto queue = [&](ALuint buffer) {
    std::array<std::int16_t, length> samples;
    load_.refresh();
    sound.next(load_.latest(), samples.data(), length);
    alBufferData(buffer, AL_FORMAT_MONO16, samples.data(), sizeof(samples), BurSound::kRate);
    alSourceQueueBuffers(source, 1, &buffer);
  };
  for (const ALuint buffer : buffers) queue(buffer);
  const char* trouble = alGetError() == AL_NO_ERROR ? nullptr : "the audio device does not play";
  const bool tells = alcIsExtensionPresent(device.get(), "ALC_EXT_disconnect") != ALC_FALSE;
  while (trouble == nullptr && !stop_.load(std::memory_order_relaxed)) {
    ALint played = 0, state = AL_PLAYING;
    alGetSourcei(source, AL_BUFFERS_PROCESSED, &played);
    for (; played > 0; --played) {
      ALuint buffer = 0;
      alSourceUnqueueBuffers(source, 1, &buffer);
      queue(buffer);
    }
    alGetSourcei(source, AL_SOURCE_STATE, &state);
    if (state != AL_PLAYING) alSourcePlay(source);  // at the start, and after an underrun
    ALCint connected = ALC_TRUE;
    if (tells) alcGetIntegerv(device.get(), ALC_CONNECTED, 1, &connected);
    if (connected == ALC_FALSE) trouble = "the audio device was disconnected";
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  alDeleteSources(1, &source);
  alDeleteBuffers(blocks, buffers.data());
  return trouble;
}

#else

const char* SoundOutput::play() noexcept { return "built without OpenAL"; }

#endif

}  // namespace enamel::viewer
