#pragma once

#include "raytrace/project/tile_blocks.h"
#include "slim/base/simd.h"

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>

namespace slim {

/// Some blocks of a tile: a byte a row of blocks, a bit a column.
class BlockMask {
public:
    static_assert(kBlockColumns == 8 && kTileBlocks % 64 == 0 &&
                  std::endian::native == std::endian::little);
    static constexpr std::size_t kWords = kTileBlocks / 64;

    bool any() const {
        std::uint64_t all = 0;
        for (const std::uint64_t word : words_) all |= word;
        return all != 0;
    }
    int count() const {
        int n = 0;
        for (const std::uint64_t word : words_) n += std::popcount(word);
        return n;
    }
    bool has(int block) const {
        return words_[static_cast<std::size_t>(block) / 64] >> (block % 64) & 1;
    }
    std::uint64_t word(std::size_t k) const { return words_[k]; }
    /// The blocks [first, first + n), n at most 32, from the low bits of some.
    [[gnu::always_inline]] void add(std::size_t first, std::uint64_t bits) {
        words_[first / 64] |= bits << (first % 64);
    }
    [[gnu::always_inline]] BlockMask& operator&=(const BlockMask& other) {
        for (std::size_t k = 0; k < kWords; ++k) words_[k] &= other.words_[k];
        return *this;
    }

private:
    std::array<std::uint64_t, kWords> words_{};
};

/// Pieces of work: (surfel, block) for the blocks of some surfels one after the other. One loop
/// over all of them costs one wrong guess of where it ends, a loop for each surfel one each.
class BlockList {
public:
    static constexpr int kMostSurfels = 16;

    int size() const { return size_; }
    int surfel(int k) const { return surfel_[k]; }
    int block(int k) const { return block_[k]; }
    void clear() { size_ = 0; }

    /// At most kMostSurfels times.
    [[gnu::always_inline]] void add(int surfel, const BlockMask& blocks) {
        for (std::size_t k = 0; k < BlockMask::kWords; ++k) {
            std::memset(surfel_ + size_, surfel, 64);
            put(blocks.word(k), static_cast<int>(k) * 64);
        }
    }

private:
    static constexpr int kRoom = kMostSurfels * kTileBlocks + 64;
    int size_ = 0;
    std::uint8_t surfel_[kRoom], block_[kRoom];

    [[gnu::always_inline]] void put(std::uint64_t bits, int first) {
        // An intrinsic beside the lanes of simd.h, which cannot tell the numbers of a mask's bits:
        // bytes are closed up.
#ifdef __AVX512VBMI2__
        alignas(64) static constexpr auto kNumbers = [] {
            std::array<std::uint8_t, 64> n{};
            for (std::size_t k = 0; k < n.size(); ++k) n[k] = static_cast<std::uint8_t>(k);
            return n;
        }();
        const __m512i numbers = _mm512_add_epi8(_mm512_load_si512(kNumbers.data()),
                                                _mm512_set1_epi8(static_cast<char>(first)));
        _mm512_storeu_si512(block_ + size_, _mm512_maskz_compress_epi8(bits, numbers));
        size_ += std::popcount(bits);
#else
        for (; bits != 0; bits &= bits - 1)
            block_[size_++] = static_cast<std::uint8_t>(first + std::countr_zero(bits));
#endif
    }
};

}  // namespace slim
