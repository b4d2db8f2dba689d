# Every package the project links, found once.
include(VantageExternals)
foreach(target
    Threads::Threads Eigen3::Eigen vantage_visp vantage_opencv vantage_lcm vantage_kdl
    PkgConfig::URDFDOM PkgConfig::CONSOLE_BRIDGE PkgConfig::TINYXML2 PkgConfig::ASSIMP PkgConfig::NLOPT PkgConfig::PCRE2 PkgConfig::NCURSESW
    vantage_yaml CLI11::CLI11 nlohmann_json::nlohmann_json meshoptimizer::meshoptimizer)
  vantage_find_external(${target} REQUIRED)
endforeach()
if(BUILD_TESTING)
  find_package(GTest REQUIRED)
  include(GoogleTest)
endif()
# The bits of AprilTags, for the simulator: in OpenCV's contributed modules before 4.7, in objdetect since.
if(OpenCV_VERSION VERSION_LESS 4.7)
  set(vantage_opencv_tags opencv_aruco)
else()
  set(vantage_opencv_tags opencv_objdetect)
endif()
