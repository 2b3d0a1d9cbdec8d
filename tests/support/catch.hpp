// Catch2 2.13 (Debian 12) and Catch2 3 have different headers and names; the tests use the names of Catch2 3.
#pragma once

#if __has_include(<catch2/catch_all.hpp>)
#include <catch2/catch_all.hpp>

using Catch::Approx;
namespace enamel::test {
using Catch::Matchers::ContainsSubstring;
}
#else
#include <catch2/catch.hpp>

namespace enamel::test {
inline auto ContainsSubstring(const std::string& part) { return Catch::Matchers::Contains(part); }
}  // namespace enamel::test
#endif

#include <Eigen/Core>
#include <type_traits>

namespace enamel::test {
/// Return rows of numbers as text.
std::string describe(const double* values, Eigen::Index rows, Eigen::Index columns, bool rowMajor);
}  // namespace enamel::test

/// Print matrices and vectors in messages without an instance of Eigen's output for every size.
template <typename T>
struct Catch::StringMaker<
    T, std::enable_if_t<std::is_same_v<typename T::Scalar, double> && (T::PlainObject::SizeAtCompileTime != 0)>> {
  static std::string convert(const T& value) {
    const auto& plain = value.eval();
    return enamel::test::describe(plain.data(), plain.rows(), plain.cols(), plain.IsRowMajor);
  }
};
