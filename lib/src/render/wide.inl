// Wide: one number for each mode, in registers of the SIMD level's width. Included once for each level, in an anonymous
// namespace. Plain loops over so few numbers are unrolled before GCC sees that they are vectors.
#if defined(__AVX2__)
constexpr int kWidth = 4;
#else
constexpr int kWidth = 2;
#endif
constexpr int kParts = kLanes / kWidth;
using Part = double __attribute__((vector_size(kWidth * sizeof(double))));
using PartInMemory __attribute__((aligned(sizeof(double)), may_alias)) = Part;
using Bits = std::uint64_t __attribute__((vector_size(kWidth * sizeof(double))));

struct Mask {
  decltype(Part{} < Part{}) part[kParts];
};

struct Wide {
  Part part[kParts];
  Wide() = default;
  Wide(double all) noexcept {
    for (Part& p : part) p = Part{} + all;
  }
  explicit Wide(const double* lane) noexcept {
    for (int i = 0; i < kParts; ++i) part[i] = *reinterpret_cast<const PartInMemory*>(lane + i * kWidth);
  }
  double operator[](int lane) const noexcept { return part[lane / kWidth][lane % kWidth]; }
};
template <typename Operation>
inline Wide each(const Operation& operation) noexcept {
  Wide result;
  for (int i = 0; i < kParts; ++i) result.part[i] = operation(i);
  return result;
}
template <typename Operation>
inline Mask test(const Operation& operation) noexcept {
  Mask result;
  for (int i = 0; i < kParts; ++i) result.part[i] = operation(i);
  return result;
}
inline Wide operator+(const Wide& a, const Wide& b) noexcept {
  return each([&](int i) { return a.part[i] + b.part[i]; });
}
inline Wide operator-(const Wide& a, const Wide& b) noexcept {
  return each([&](int i) { return a.part[i] - b.part[i]; });
}
inline Wide operator*(const Wide& a, const Wide& b) noexcept {
  return each([&](int i) { return a.part[i] * b.part[i]; });
}
inline Wide operator/(const Wide& a, const Wide& b) noexcept {
  return each([&](int i) { return a.part[i] / b.part[i]; });
}
inline Wide operator-(const Wide& a) noexcept {
  return each([&](int i) { return -a.part[i]; });
}
inline Wide& operator+=(Wide& a, const Wide& b) noexcept { return a = a + b; }
inline Wide& operator*=(Wide& a, const Wide& b) noexcept { return a = a * b; }
inline Mask operator<(const Wide& a, const Wide& b) noexcept {
  return test([&](int i) { return a.part[i] < b.part[i]; });
}
inline Mask operator>(const Wide& a, const Wide& b) noexcept { return b < a; }
inline Mask operator&(const Mask& a, const Mask& b) noexcept {
  return test([&](int i) { return a.part[i] & b.part[i]; });
}
inline Wide select(const Mask& mask, const Wide& yes, const Wide& no) noexcept {
  return each([&](int i) { return mask.part[i] ? yes.part[i] : no.part[i]; });
}
// The same in memory.
struct Stored {
  double* lane;
  explicit Stored(double* at) noexcept : lane(at) {}
  Stored(const Stored&) = default;
  Stored& operator=(const Stored&) = delete;  // would copy the address
  operator Wide() const noexcept { return Wide(lane); }
  void operator=(const Wide& value) const noexcept {
    for (int i = 0; i < kParts; ++i) *reinterpret_cast<PartInMemory*>(lane + i * kWidth) = value.part[i];
  }
  void operator+=(const Wide& value) const noexcept { *this = Wide(lane) + value; }
  void operator-=(const Wide& value) const noexcept { *this = Wide(lane) - value; }
  void operator*=(const Wide& value) const noexcept { *this = Wide(lane) * value; }
};
inline Stored wide(double* lane) noexcept { return Stored(lane); }
inline Stored wide(Lane& lane) noexcept { return Stored(lane.data()); }
inline Wide wide(const double* lane) noexcept { return Wide(lane); }
inline Wide wide(const Lane& lane) noexcept { return Wide(lane.data()); }

inline Wide larger(const Wide& a, const Wide& b) noexcept { return select(a > b, a, b); }
inline Wide smaller(const Wide& a, const Wide& b) noexcept { return select(a < b, a, b); }
inline Wide magnitudeOf(const Wide& a) noexcept { return select(a < 0.0, -a, a); }
inline Wide rootOf(const Wide& a) noexcept {
#if defined(__AVX2__)
  return each([&](int i) { return _mm256_sqrt_pd(a.part[i]); });
#else
  return each([&](int i) { return Part{std::sqrt(a.part[i][0]), std::sqrt(a.part[i][1])}; });
#endif
}
