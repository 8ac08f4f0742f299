#include "raytrace/font_glyphs.h"

namespace slim {
namespace {

// Drawn for this project; geometric, all strokes of one width.
constexpr Glyph kGlyphs[] = {
    {' ', 3, ""},
    {'0', 9, "M9 7 A4.5 7 4.5 7 0 360"},
    {'1', 6, "M1 11 L4.5 14 L4.5 0"},
    {'2', 9, "M.3 10.5 A4.5 9.8 4.2 4.2 170 -38 L0 0 L9 0"},
    {'3', 9, "M.7 11.6 A4.4 10.5 3.9 3.5 160 -90 A4.4 3.5 4.5 3.5 90 -160"},
    {'4', 9.5f, "M7 0 L7 14 L0 4 L9.5 4"},
    {'5', 9, "M8 14 L1.4 14 L.9 7.2 A4.4 4.5 4.5 4.5 142 -155"},
    {'6', 9, "M9 4.5 A4.5 4.5 4.5 4.5 0 360 M0 4.5 A8.2 4.5 8.2 9.5 180 98"},
    {'7', 8.5f, "M0 14 L8.5 14 L3 0"},
    {'8', 9, "M8.2 10.5 A4.5 10.5 3.7 3.5 0 360 M9 3.5 A4.5 3.5 4.5 3.5 0 360"},
    {'9', 9, "M9 9.5 A4.5 9.5 4.5 4.5 0 360 M9 9.5 A.8 9.5 8.2 9.5 0 -82"},
    {'A', 10.5f, "M0 0 L5.25 14 L10.5 0 M1.8 4.8 L8.7 4.8"},
    {'B', 9,
     "M0 0 L0 14 L4.6 14 A4.6 10.6 3.6 3.4 90 -90 L0 7.2 M4.6 7.2 A4.8 3.6 4.2 3.6 90 -90 L0 0"},
    {'C', 10.5f, "M10.3 12 A6 7 6 7 45 315"},
    {'D', 10.5f, "M0 0 L0 14 L3.5 14 A3.5 7 7 7 90 -90 L0 0"},
    {'E', 8, "M8 14 L0 14 L0 0 L8 0 M0 7.3 L7 7.3"},
    {'F', 8, "M8 14 L0 14 L0 0 M0 7 L7 7"},
    {'G', 11.5f, "M10.3 12 A6 7 6 7 45 335 L11.5 6.4 L7 6.4"},
    {'H', 9.5f, "M0 0 L0 14 M9.5 0 L9.5 14 M0 7.2 L9.5 7.2"},
    {'I', 1, "M.5 0 L.5 14"},
    {'J', 6, "M6 14 L6 4 A3 4 3 4 0 -170"},
    {'K', 9, "M0 0 L0 14 M8.5 14 L0 5 M3.2 8.4 L9 0"},
    {'L', 7.5f, "M0 14 L0 0 L7.5 0"},
    {'M', 12, "M0 0 L0 14 L6 4 L12 14 L12 0"},
    {'N', 9.5f, "M0 0 L0 14 L9.5 0 L9.5 14"},
    {'O', 12.5f, "M12.5 7 A6.25 7 6.25 7 0 360"},
    {'P', 8.7f, "M0 0 L0 14 L4.7 14 A4.7 10.2 4 3.8 90 -90 L0 6.4"},
    {'Q', 12.5f, "M12.5 7 A6.25 7 6.25 7 0 360 M7.8 3.8 L12.4 -.8"},
    {'R', 9, "M0 0 L0 14 L4.7 14 A4.7 10.2 4 3.8 90 -90 L0 6.4 M4.5 6.4 L9 0"},
    {'S', 9, "M8 12 A4.4 10.6 4 3.4 30 270 A4.4 3.6 4.5 3.6 90 -155"},
    {'T', 9.5f, "M0 14 L9.5 14 M4.75 14 L4.75 0"},
    {'U', 9.5f, "M0 14 L0 4.75 A4.75 4.75 4.75 4.75 180 360 L9.5 14"},
    {'V', 10.5f, "M0 14 L5.25 0 L10.5 14"},
    {'W', 15, "M0 14 L3.75 0 L7.5 14 L11.25 0 L15 14"},
    {'X', 9.5f, "M0 14 L9.5 0 M9.5 14 L0 0"},
    {'Y', 9.5f, "M0 14 L4.75 6.8 L9.5 14 M4.75 6.8 L4.75 0"},
    {'Z', 9, "M0 14 L9 14 L0 0 L9 0"},
    {'a', 8.8f, "M8.8 10 L8.8 0 M8.8 5 A4.4 5 4.4 5 0 360"},
    {'b', 8.8f, "M0 14.5 L0 0 M0 5 A4.4 5 4.4 5 180 -180"},
    {'c', 8, "M7.5 8.6 A4.4 5 4.4 5 46 314"},
    {'d', 8.8f, "M8.8 14.5 L8.8 0 M8.8 5 A4.4 5 4.4 5 0 360"},
    {'e', 8.8f, "M0 5 L8.8 5 A4.4 5 4.4 5 0 318"},
    {'f', 5.5f, "M5.5 14.3 A5 11.5 3 3 80 180 L2 0 M0 10 L5.2 10"},
    {'g', 8.8f, "M8.8 5 A4.4 5 4.4 5 0 360 M8.8 10 L8.8 -.2 A4.4 -.2 4.4 4 0 -145"},
    {'h', 8, "M0 14.5 L0 0 M0 5.6 A4 5.8 4 4.2 180 0 L8 0"},
    {'i', 1, "M.5 10 L.5 0 M.5 13.7 L.5 13.8"},
    {'j', 3, "M2.5 10 L2.5 -1.5 A0 -1.5 2.5 2.5 0 -90 M2.5 13.7 L2.5 13.8"},
    {'k', 7.5f, "M0 14.5 L0 0 M7 10 L0 3.8 M2.6 6.1 L7.5 0"},
    {'l', 1, "M.5 14.5 L.5 0"},
    {'m', 12.6f,
     "M0 10 L0 0 M0 6 A3.15 6.5 3.15 3.5 180 0 L6.3 0 M6.3 6 A9.45 6.5 3.15 3.5 180 0 L12.6 0"},
    {'n', 8, "M0 10 L0 0 M0 5.6 A4 5.8 4 4.2 180 0 L8 0"},
    {'o', 9, "M9 5 A4.5 5 4.5 5 0 360"},
    {'p', 8.8f, "M0 10 L0 -4.2 M0 5 A4.4 5 4.4 5 180 -180"},
    {'q', 8.8f, "M8.8 10 L8.8 -4.2 M8.8 5 A4.4 5 4.4 5 0 360"},
    {'r', 5, "M0 10 L0 0 M0 5.5 A4 6 4 4 180 75"},
    {'s', 7.2f, "M6.3 8.7 A3.6 7.6 3.1 2.4 28 270 A3.6 2.6 3.6 2.6 90 -152"},
    {'t', 5.6f, "M2.2 13.5 L2.2 3 A5 3 2.8 3 180 282 M0 10 L5.4 10"},
    {'u', 8, "M0 10 L0 4.2 A4 4.2 4 4.2 180 360 M8 10 L8 0"},
    {'v', 8, "M0 10 L4 0 L8 10"},
    {'w', 12, "M0 10 L3 0 L6 10 L9 0 L12 10"},
    {'x', 7.5f, "M0 10 L7.5 0 M7.5 10 L0 0"},
    {'y', 8, "M0 10 L4.1 .2 M8 10 L3.6 -1.6 A1.2 -1.2 2.6 3 -20 -95"},
    {'z', 7.5f, "M.2 10 L7.3 10 L0 0 L7.5 0"},
    {'.', 1.2f, "M.6 .2 L.6 .3"},
    {',', 1.6f, "M1.1 .6 L.2 -2.4"},
    {':', 1.2f, "M.6 .3 L.6 .4 M.6 8.6 L.6 8.7"},
    {';', 1.6f, "M1.1 .6 L.2 -2.4 M1 8.6 L1 8.7"},
    {'!', 1.2f, "M.6 14 L.6 4 M.6 .2 L.6 .3"},
    {'?', 7, "M0 11 A3.4 10.6 3.4 3.4 175 -60 L3.4 5.6 L3.4 4 M3.4 .2 L3.4 .3"},
    {'\'', 1, "M.5 14 L.5 10.5"},
    {'"', 4, "M.5 14 L.5 10.5 M3.5 14 L3.5 10.5"},
    {'+', 9, "M0 6 L9 6 M4.5 10.5 L4.5 1.5"},
    {'-', 5, "M0 5.2 L5 5.2"},
    {'=', 9, "M0 8.2 L9 8.2 M0 3.8 L9 3.8"},
    {'<', 8, "M8 10.5 L0 6 L8 1.5"},
    {'>', 8, "M0 10.5 L8 6 L0 1.5"},
    {'/', 6, "M0 -1.5 L6 15"},
    {'\\', 6, "M0 15 L6 -1.5"},
    {'|', 1, "M.5 -3 L.5 15.5"},
    {'_', 8, "M0 -1.5 L8 -1.5"},
    {'(', 3.4f, "M3.4 15.5 A6.4 6 6.4 10.5 117 243"},
    {')', 3.4f, "M0 15.5 A-3 6 6.4 10.5 63 -63"},
    {'[', 3.4f, "M3.4 15.5 L0 15.5 L0 -3 L3.4 -3"},
    {']', 3.4f, "M0 15.5 L3.4 15.5 L3.4 -3 L0 -3"},
    {'*', 6, "M3 14 L3 8 M.4 12.5 L5.6 9.5 M.4 9.5 L5.6 12.5"},
    {'#', 9, "M2 0 L4 14 M6 0 L8 14 M.5 9.4 L9 9.4 M0 4.6 L8.5 4.6"},
    {'%', 13, "M2 0 L11 14 M5.6 10.9 A2.8 10.9 2.8 3.1 0 360 M13 3.1 A10.2 3.1 2.8 3.1 0 360"},
    {'^', 7, "M0 9.5 L3.5 14 L7 9.5"},
    {'&', 10, "M10 0 L2.3 9.6 A4.6 11.2 2.8 2.8 218 -40 L2 6.4 A4 3.8 4 3.8 125 318 L9.4 6.6"},
    {'~', 8, "M0 5 A2.2 5.2 2.1 1.8 180 0 A6 5.2 2 1.8 180 360"},
    {U'\u00df', 8.6f,
     "M0 0 L0 10.5 A3.8 10.8 3.8 3.7 180 -60 L4.6 8 A4.6 4 4 4 90 -130"},  // sharp s
    {U'\u00e6', 15.4f,
     "M8.2 5 A4.1 5 4.1 5 0 360 M8.2 10 L8.2 5 L15.4 5 A11.8 5 3.6 5 0 318 M8.2 5 L8.2 0"},  // ae
    {U'\u00c6', 14, "M0 0 L7 14 L14 14 M7 14 L7 0 L14 0 M2.4 4.8 L7 4.8 M7 7.3 L13 7.3"},    // AE
    {U'\u00f8', 9, "M9 5 A4.5 5 4.5 5 0 360 M0 -.8 L9 10.8"},                   // o with stroke
    {U'\u00d8', 12.5f, "M12.5 7 A6.25 7 6.25 7 0 360 M1 -1 L11.5 15"},          // O with stroke
    {U'\u0131', 1, "M.5 10 L.5 0"},                                             // dotless i
    {U'\u2212', 9, "M0 6 L9 6"},                                                // minus
    {U'\u00b0', 5, "M5 11.8 A2.5 11.8 2.5 2.5 0 360"},                          // degree
    {U'\u00b1', 9, "M0 7.5 L9 7.5 M4.5 12 L4.5 3 M0 .6 L9 .6"},                 // plus-minus
    {U'\u00b2', 5, "M.2 12.6 A2.5 12.3 2.3 2.2 170 -40 L0 7.2 L5 7.2"},         // squared
    {U'\u00b3', 5, "M.4 13.5 A2.4 12.8 2 1.9 155 -90 A2.4 9 2.4 1.9 90 -155"},  // cubed
    {U'\u00b5', 8, "M0 10 L0 -4 M0 4.2 A4 4.2 4 4.2 180 360 M8 10 L8 0"},       // micro
    {U'\u00b7', 1.2f, "M.6 6 L.6 6.1"},                                         // middle dot
    {U'\u00d7', 7, "M0 9.5 L7 2.5 M7 9.5 L0 2.5"},                              // times
};

/// Marks over small letters, their middle at 0.
constexpr const char* kGrave = "M-1.8 14.4 L.8 12";
constexpr const char* kAcute = "M1.8 14.4 L-.8 12";
constexpr const char* kHat = "M-2.4 12 L0 14.4 L2.4 12";
constexpr const char* kTilde = "M-2.8 12.6 A-1.3 12.7 1.4 1 180 0 A1.4 12.7 1.4 1 180 360";
constexpr const char* kDots = "M-1.9 13.4 L-1.9 13.5 M1.9 13.4 L1.9 13.5";
constexpr const char* kRing = "M1.5 13.2 A0 13.2 1.5 1.5 0 360";
constexpr const char* kCedilla = "M0 0 L0 -1.2 A-.4 -2.5 1.5 1.3 80 -130";

struct Accented {
    char32_t code, letter;
    const char* mark;
};
constexpr Accented kAccented[] = {
    {U'\u00c0', 'A', kGrave},   {U'\u00c1', 'A', kAcute}, {U'\u00c2', 'A', kHat},
    {U'\u00c3', 'A', kTilde},   {U'\u00c4', 'A', kDots},  {U'\u00c5', 'A', kRing},
    {U'\u00c7', 'C', kCedilla}, {U'\u00c8', 'E', kGrave}, {U'\u00c9', 'E', kAcute},
    {U'\u00ca', 'E', kHat},     {U'\u00cb', 'E', kDots},  {U'\u00cc', 'I', kGrave},
    {U'\u00cd', 'I', kAcute},   {U'\u00ce', 'I', kHat},   {U'\u00cf', 'I', kDots},
    {U'\u00d1', 'N', kTilde},   {U'\u00d2', 'O', kGrave}, {U'\u00d3', 'O', kAcute},
    {U'\u00d4', 'O', kHat},     {U'\u00d5', 'O', kTilde}, {U'\u00d6', 'O', kDots},
    {U'\u00d9', 'U', kGrave},   {U'\u00da', 'U', kAcute}, {U'\u00db', 'U', kHat},
    {U'\u00dc', 'U', kDots},    {U'\u00dd', 'Y', kAcute}, {U'\u00e0', 'a', kGrave},
    {U'\u00e1', 'a', kAcute},   {U'\u00e2', 'a', kHat},   {U'\u00e3', 'a', kTilde},
    {U'\u00e4', 'a', kDots},    {U'\u00e5', 'a', kRing},  {U'\u00e7', 'c', kCedilla},
    {U'\u00e8', 'e', kGrave},   {U'\u00e9', 'e', kAcute}, {U'\u00ea', 'e', kHat},
    {U'\u00eb', 'e', kDots},    {U'\u00ec', U'\u0131', kGrave},
    {U'\u00ed', U'\u0131', kAcute},                      {U'\u00ee', U'\u0131', kHat},
    {U'\u00ef', U'\u0131', kDots},                       {U'\u00f1', 'n', kTilde},
    {U'\u00f2', 'o', kGrave},   {U'\u00f3', 'o', kAcute}, {U'\u00f4', 'o', kHat},
    {U'\u00f5', 'o', kTilde},   {U'\u00f6', 'o', kDots},  {U'\u00f9', 'u', kGrave},
    {U'\u00fa', 'u', kAcute},   {U'\u00fb', 'u', kHat},   {U'\u00fc', 'u', kDots},
    {U'\u00fd', 'y', kAcute},   {U'\u00ff', 'y', kDots},
};

constexpr Glyph kMissing{0, 8, "M0 0 L0 14 L8 14 L8 0 L0 0"};

const Glyph* find_glyph(char32_t code) {
    for (const Glyph& glyph : kGlyphs)
        if (glyph.code == code) return &glyph;
    return nullptr;
}

}  // namespace

Glyph glyph_of(char32_t code) {
    if (const Glyph* glyph = find_glyph(code)) return *glyph;
    for (const Accented& a : kAccented) {
        if (a.code != code) continue;
        constexpr float kHigher = 4;  // over capitals
        Glyph glyph = *find_glyph(a.letter);
        const bool capital = a.letter >= 'A' && a.letter <= 'Z', below = a.mark == kCedilla;
        glyph.code = code, glyph.mark = a.mark;
        glyph.mark_x = glyph.advance / 2, glyph.mark_y = capital && !below ? kHigher : 0.0f;
        return glyph;
    }
    return kMissing;
}

}  // namespace slim
