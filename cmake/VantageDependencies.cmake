# Every package the project links, found once.
include(VantageExternals)
foreach(target
    Threads::Threads Eigen3::Eigen vantage_visp vantage_opencv vantage_lcm vantage_kdl
    PkgConfig::URDFDOM PkgConfig::TINYXML2 PkgConfig::ASSIMP PkgConfig::NLOPT PkgConfig::PCRE2
    vantage_yaml CLI11::CLI11 spdlog::spdlog nlohmann_json::nlohmann_json)
  vantage_find_external(${target} REQUIRED)
endforeach()
if(BUILD_TESTING)
  find_package(GTest REQUIRED)
  include(GoogleTest)
endif()
