#include "tests/pipeline/build/normals_stage_support.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <string>
#include <utility>

namespace slim::test {
namespace {

using Sensors = NormalsStage;

TEST_F(Sensors, TakesDirectionsOfScannersThatAreFar) {
    // Seen along -x, a sphere's normals all point to -x, also at the back.
    const std::string path = write(sampled("sphere", 5000), "c.ply", false);
    folder_.write("c.scans.json", R"({"scans": [{"id": 0, "direction": [-2, 0, 0]}]})");
    slice(path, 1);
    EXPECT_EQ(normals()["oriented_by_sensor"], 5000);
    std::size_t towards = 0;
    for (const Vec3f& n : oriented().normal) towards += n.x <= 1e-3f;
    EXPECT_EQ(towards, 5000u);
}

TEST_F(Sensors, UsesTheSensorsBesideTheCloud) {
    // A scanner in the middle of the sphere sees it from inside.
    Cloud cloud = sampled("sphere", 5000);
    const std::string path = write(cloud, "c.ply", false);
    folder_.write("c.scans.json", R"({"scans": [{"id": 0, "position": [0, 0, 0]}]})");
    slice(path, 1);
    const auto r = normals();
    EXPECT_EQ(r["oriented_by_sensor"], 5000);
    EXPECT_EQ(inwards(oriented()), 5000u);
}

// Noise as large as the spacing tilts estimates by 15 degrees and more: where a scanner looks along
// the surface it gives them the wrong sign.
TEST_F(Sensors, SignsThatASensorGetsWrongAreTurnedByTheNeighbours) {
    const Cloud cloud = sampled("sphere", 20000, 1, 5e-3);
    const std::string path = write(cloud, "c.ply", false);
    // From inside, near the surface: nothing is seen at more than 82 degrees.
    folder_.write("c.scans.json", R"({"scans": [{"id": 0, "position": [0, 0, 0.99]}]})");
    slice(path, 1);
    const auto r = normals();
    EXPECT_EQ(r["oriented_by_sensor"], 20000);
    EXPECT_EQ(r["turned"], 0);  // that is of a cloud's own
    const std::size_t turned = r["estimates_turned"], outwards = 20000 - inwards(oriented());
    EXPECT_GT(turned, 100u);
    EXPECT_LT(2 * outwards, turned);
}

TEST_F(Sensors, AFolderIsNoFileOfSensors) {
    slice(write(sampled("sphere", 500), "c.ply", false), 1);
    NormalsConfig c;
    c.sensors = file(".");
    EXPECT_EQ(code_of([&] { normals(c); }), ExitCode::bad_data);
}

TEST_F(Sensors, SensorsThatAreNoneAreRefusedByScanAndFile) {
    const std::string path = write(sampled("sphere", 500), "c.ply", false);
    const auto refused = [&](const std::string& entry) -> std::string {
        folder_.write("c.scans.json", "{\"scans\": [" + entry + "]}");
        slice(path, 1);
        try {
            normals();
            return "";
        } catch (const FormatError& error) {
            return error.what();
        }
    };
    for (const auto& [entry, told] :
         {std::pair{R"({"id": 0, "direction": [0, 0, 0]})",
                    "scan 0: direction: expected one that is not zero, found [0,0,0]"},
          std::pair{R"({"id": 4294967296, "position": [0, 0, 9]})", "scan 4294967296:"},
          std::pair{R"({"id": 65536, "position": [0, 0, 9]})", "scan 65536:"},
          std::pair{R"({"id": -1, "position": [0, 0, 9]})", "scan -1:"},
          std::pair{R"({"id": 0.5, "position": [0, 0, 9]})", "scan 0.5:"},
          std::pair{R"({"id": 0, "position": [0, 9]})",
                    "scan 0: position: expected 3 numbers, found [0,9]"},
          std::pair{R"({"id": 0, "position": [0, null, 9]})",
                    "scan 0: position: expected 3 numbers"},
          std::pair{R"({"id": 0, "position": [0, 1e999, 9]})", "expected JSON, found a number"},
          std::pair{R"({"position": [0, 1, 9]})", "entry 1 of scans: expected an \"id\""},
          std::pair{R"({"id": 0})", "entry 1 of scans: expected a \"position\" or"},
          std::pair{R"(7)", "entry 1 of scans: expected an object, found 7"},
          std::pair{R"({"id": 0, "position": [0, 1, 9)", "expected JSON, found the end of the file"}}) {
        const std::string message = refused(entry);
        EXPECT_NE(message.find(told), std::string::npos) << entry << ": " << message;
        EXPECT_NE(message.find("c.scans.json"), std::string::npos) << message;
        EXPECT_EQ(message.find("json.exception"), std::string::npos) << message;
    }
    EXPECT_EQ(refused(R"({"id": 0, "direction": [0, 0, 1e-200]})"), "");
}

TEST_F(Sensors, SlicesMadeWithOtherSensorsDoNotGoTogether) {
    slice(write(sampled("sphere", 6000), "c.ply", false), 2);
    const auto with_sensors = [&](int number, const char* name, const char* z) {
        folder_.write(name,
                      fmt::format(R"({{"scans": [{{"id": 0, "position": [0, 0, {}]}}]}})", z));
        NormalsConfig c;
        c.slice = number, c.sensors = file(name);
        normals(c);
    };
    with_sensors(0, "a.json", "9"), with_sensors(1, "b.json", "-9");
    EXPECT_EQ(code_of([&] { fit(); }), ExitCode::incomplete);
    for (const char* name : {"a.json", "b.json"})
        EXPECT_NE(message_.find(std::string("--sensors ") + file(name)), std::string::npos)
            << message_;
    // Their positions count, not what the file is called.
    with_sensors(1, "b.json", "9");
    EXPECT_EQ(code_of([&] { fit(); }), ExitCode::ok) << message_;
}

}  // namespace
}  // namespace slim::test
