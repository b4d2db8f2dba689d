# Every package the project links, found once. No versions: Debian 12 and 13 both serve.
find_package(PkgConfig REQUIRED)
find_package(Threads REQUIRED)
find_package(Eigen3 REQUIRED NO_MODULE)
find_package(OpenCV REQUIRED COMPONENTS core imgproc imgcodecs videoio calib3d)
find_package(yaml-cpp REQUIRED)
find_package(CLI11 REQUIRED)
find_package(spdlog REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(orocos_kdl REQUIRED)
find_package(GTest REQUIRED)
pkg_check_modules(URDFDOM REQUIRED IMPORTED_TARGET urdfdom)
pkg_check_modules(TINYXML2 REQUIRED IMPORTED_TARGET tinyxml2)
pkg_check_modules(ASSIMP REQUIRED IMPORTED_TARGET assimp)
pkg_check_modules(NLOPT REQUIRED IMPORTED_TARGET nlopt)
pkg_check_modules(PCRE2 REQUIRED IMPORTED_TARGET libpcre2-8)
include(GoogleTest)

# OpenCV's and yaml-cpp's headers are not ours to warn about.
add_library(vantage_opencv INTERFACE)
target_include_directories(vantage_opencv SYSTEM INTERFACE ${OpenCV_INCLUDE_DIRS})
target_link_libraries(vantage_opencv INTERFACE opencv_core opencv_imgproc opencv_imgcodecs opencv_videoio opencv_calib3d)

# VISPConfig.cmake appends -fopenmp and -fPIC to CMAKE_CXX_FLAGS and sets CMAKE_CXX_STANDARD for whoever
# calls it; the scope of a function keeps that from the other targets.
function(vantage_find_visp)
  find_package(VISP REQUIRED)
  add_library(vantage_visp INTERFACE)
  target_include_directories(vantage_visp SYSTEM INTERFACE ${VISP_INCLUDE_DIRS})
  target_link_libraries(vantage_visp INTERFACE visp_core visp_visual_features visp_vs visp_blob visp_detection visp_io)
endfunction()
vantage_find_visp()
