#include "slim/base/hash.h"
#include "slim/base/parallel.h"
#include "slim/base/simd.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <stdexcept>
#include <vector>

namespace slim::test {
namespace {

template <class V>
void compresses_every_mask() {
    using T = typename V::value_type;
    T values[V::size()];
    for (std::size_t i = 0; i < V::size(); ++i) values[i] = static_cast<T>(10 + i);
    const V v(values, stdx::element_aligned);
    for (std::uint64_t bits = 0; bits < std::uint64_t{1} << V::size(); ++bits) {
        std::vector<T> expected;
        for (std::size_t i = 0; i < V::size(); ++i)
            if (bits >> i & 1) expected.push_back(values[i]);
        std::vector<T> out(V::size() + 1, T(7));
        if constexpr (std::is_same_v<V, FloatV>) compress_to(v, bits, out.data());
        else compress_to<T>(v, bits, out.data());
        EXPECT_EQ(out.back(), T(7)) << "wrote beyond the lanes, mask " << bits;
        out.resize(expected.size());
        EXPECT_EQ(out, expected) << "mask " << bits;
    }
}

TEST(CompressTo, KeepsTheLanesWhoseBitIsSetInOrder) {
    compresses_every_mask<LanesOfDouble<double>>();
    compresses_every_mask<LanesOfDouble<float>>();
    compresses_every_mask<LanesOfDouble<std::uint32_t>>();
    compresses_every_mask<FloatV>();
}

TEST(StoreInterleaved, TakesOneOfEachInTurn) {
    float values[4][kLanes];
    for (std::size_t c = 0; c < 4; ++c)
        for (std::size_t k = 0; k < kLanes; ++k) values[c][k] = static_cast<float>(100 * c + k);
    const auto v = [&](std::size_t c) { return FloatV(values[c], stdx::element_aligned); };
    std::vector<float> out(4 * kLanes + 1, 7);
    store_interleaved(v(0), v(1), v(2), v(3), out.data());
    for (std::size_t i = 0; i < 4 * kLanes; ++i) EXPECT_EQ(out[i], values[i % 4][i / 4]) << i;
    EXPECT_EQ(out.back(), 7);
}

TEST(LanesOfBits, AreThoseOfTheBytes) {
    std::vector<std::uint8_t> bytes(kLanes);
    for (std::uint32_t bits = 0; bits < 1u << kLanes; bits += kLanes > 8 ? 97 : 1) {
        for (std::size_t k = 0; k < kLanes; ++k) bytes[k] = bits >> k & 1;
        for (std::size_t n = 0; n <= kLanes; ++n)
            ASSERT_EQ(bits_of_bytes(bytes.data(), n), bits & ((std::uint64_t{1} << n) - 1));
        ASSERT_EQ(lane_bits(lanes_of_bits(bits)), bits);
    }
}

TEST(ParallelEraseIf, IsStdEraseIf) {
    const ThreadLimit limit(3);
    for (const std::size_t n : {0u, 1u, 16384u, 16385u, 100000u})
        for (const std::uint64_t share : {0u, 1u, 7u, 8u}) {
            SCOPED_TRACE(testing::Message() << n << " values, " << share << " of 8 unwanted");
            std::vector<std::uint64_t> values(n);
            for (std::size_t i = 0; i < n; ++i) values[i] = keyed_hash(4, i);
            const auto unwanted = [&](std::uint64_t v) { return v % 8 < share; };
            std::vector<std::uint64_t> expected = values;
            std::erase_if(expected, unwanted);
            parallel_erase_if(values, unwanted);
            EXPECT_EQ(values, expected);
        }
}

TEST(RunBoth, DoesBothAndThrowsWhatEitherThrows) {
    for (const int threads : {1, 3}) {
        const ThreadLimit limit(threads);
        int a = 0, b = 0;
        run_both([&] { a = 1; }, [&] { b = 2; });
        EXPECT_EQ(a + b, 3);
        const auto fails = [] { throw std::runtime_error("no"); };
        EXPECT_THROW(run_both(fails, [] {}), std::runtime_error);
        EXPECT_THROW(run_both([] {}, fails), std::runtime_error);
    }
}

// Each piece reads what the one before it wrote, with no lock but the order.
TEST(WorkAside, PiecesAreDoneOneAfterTheOther) {
    for (const int threads : {1, 3}) {
        const ThreadLimit limit(threads);
        WorkAside aside;
        std::vector<int> done;
        for (int i = 0; i < 1000; ++i) {
            aside.run([&done, i] { done.push_back(i); });
            parallel_blocks(4, 1, [](std::size_t, std::size_t) {});
        }
        aside.wait();
        ASSERT_EQ(done.size(), 1000u);
        for (int i = 0; i < 1000; ++i) ASSERT_EQ(done[static_cast<std::size_t>(i)], i);
    }
}

TEST(WorkAside, ThrowsWhatAPieceThrewOnce) {
    for (const int threads : {1, 3}) {
        const ThreadLimit limit(threads);
        WorkAside aside;
        aside.run([] { throw std::runtime_error("no"); });
        EXPECT_THROW(aside.wait(), std::runtime_error);
        int a = 0;
        aside.run([&] { a = 1; });
        aside.wait();
        EXPECT_EQ(a, 1);
        aside.run([] { throw std::runtime_error("nobody waits for it"); });
    }
}

}  // namespace
}  // namespace slim::test
