#include "raytrace/font.h"

#include "tests/raytrace/support/ink.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

namespace slim {
namespace {

using test::n_different;
using test::n_inked;
using test::white;

TEST(Font, EveryPrintableCharacterHasAGlyphOfItsOwn) {
    Picture missing = white(40, 40);
    draw_text(missing, "\x01", 8, 30, {});
    for (char c = '!'; c <= '~'; ++c) {
        if (std::string("$@`{}").find(c) != std::string::npos) continue;  // not drawn for legends
        Picture p = white(40, 40);
        draw_text(p, std::string(1, c), 8, 30, {});
        EXPECT_GT(n_inked(p), 3) << c;
        EXPECT_GT(n_different(p, missing), 3) << c;
    }
    for (const char* sign :
         {"\u2212", "\u00b0", "\u00b1", "\u00b2", "\u00b3", "\u00b5", "\u00b7"}) {
        Picture p = white(40, 40);
        draw_text(p, sign, 8, 30, {});
        EXPECT_GT(n_different(p, missing), 3) << sign;
    }
}

/// A Latin-1 character as UTF-8.
std::string latin_1(int code) {
    return {static_cast<char>(0xc0 | code >> 6), static_cast<char>(0x80 | (code & 63))};
}

TEST(Font, LettersOfLatin1AreTheirOwn) {
    const auto drawn = [](const std::string& text) {
        Picture p = white(48, 56);
        draw_text(p, text, 12, 38, {.cap_height = 20});
        return p;
    };
    std::vector<Picture> seen{drawn("\x01")};
    for (char c = 'A'; c <= 'z'; ++c) seen.push_back(drawn(std::string(1, c)));
    for (int code = 0xc0; code <= 0xff; ++code) {
        if (code == 0xd7 || code == 0xf7) continue;  // times, divide
        const bool is_icelandic = (code & 0xdf) == 0xd0 || (code & 0xdf) == 0xde;
        EXPECT_EQ(without_glyphs(latin_1(code)).empty(), !is_icelandic) << code;
        if (is_icelandic) continue;
        const Picture p = drawn(latin_1(code));
        for (const Picture& other : seen) EXPECT_GT(n_different(p, other), 3) << code;
        seen.push_back(p);
    }
    // An accent stands above its letter, and a letter is as wide with one as without.
    EXPECT_GT(n_different(drawn("\u00e8"), drawn("e")), 3);
    EXPECT_EQ(text_width("\u00e8\u00c8", {}), text_width("eE", {}));
}

TEST(Font, WidthAndColourAndClippingHold) {
    TextStyle style;
    style.color = {1, 0, 0};
    Picture p = white(200, 40);
    draw_text(p, "0123", 10, 30, style);
    const float width = text_width("0123", style);
    int last = 0;
    for (int y = 0; y < p.height; ++y)
        for (int x = 0; x < p.width; ++x)
            if (p.pixel(x, y)[1] < 0.9f) {
                EXPECT_NEAR(p.pixel(x, y)[0], 1, 1e-5);
                last = std::max(last, x);
            }
    EXPECT_NEAR(static_cast<float>(last), 10 + width, 3);
    EXPECT_NEAR(text_width("0123", {28}), 2 * width, 1e-3);
    Picture small = white(8, 8);
    draw_text(small, "Wide text that does not fit \xff\xc3", -20, 4, style);
    EXPECT_EQ(small.rgba.size(), 8u * 8 * 4);
}

}  // namespace
}  // namespace slim
