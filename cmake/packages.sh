# Sourced by demo.sh and check.sh: installs missing Debian packages and prints their names.

packages="g++ cmake ninja-build libeigen3-dev libopenmesh-dev libtomlplusplus-dev libcli11-dev nlohmann-json3-dev libfmt-dev catch2"
# The viewer: everything else can be built without these. VTK is a download of 400 MB, and therefore a separate step.
viewer_packages="libglfw3-dev libglm-dev libglew-dev libimgui-dev libegl-dev libgl-dev libegl-mesa0 libgl1-mesa-dri \
pkg-config fonts-roboto-unhinted xvfb"
vtk_packages="libvtk9-dev"
multibody_packages="libsimbody-dev"  # a second physics engine: enamel push --plant multibody
python_packages="python3-dev pybind11-dev python3-numpy"
fmi_packages="libzip-dev libpugixml-dev"  # units of FMI: enamel fmu, --plant FILE.fmu
sound_packages="libopenal-dev"
driver_packages="libboost-dev"  # the driver haply: WebSockets by Boost.Beast
page_packages="libjs-three libjs-vega zlib1g-dev"  # enamel replay --html, figures of reports
person_packages="xdotool libx11-dev"  # tests: real keys and clicks, dropped files

is_installed() { dpkg-query -W -f='${Status}' "$1" 2>/dev/null | grep -q 'install ok installed'; }

# Installs those of the named packages that are missing. On failure it prints the last lines of apt-get.
install_step() {
  missing=
  for package in "$@"; do
    is_installed "$package" || missing="$missing $package"
  done
  [ -n "$missing" ] || return 0
  echo "== installing:$missing"
  as_root=
  if [ "$(id -u)" -ne 0 ]; then
    if ! command -v sudo >/dev/null 2>&1; then
      echo "error: these Debian packages are missing and there is neither root nor sudo to install them:$missing" >&2
      return 1
    fi
    as_root=sudo
  fi
  if ! { $as_root apt-get update -qq &&
         $as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends $missing; } \
         >/tmp/enamel-packages.$$ 2>&1; then
    tail -n 5 "/tmp/enamel-packages.$$" >&2
    echo "error: cannot install these Debian packages:$missing" >&2
    return 1
  fi
  rm -f "/tmp/enamel-packages.$$"
}

install_packages() {
  install_step $packages || exit 1
  CMAKE_GENERATOR=${CMAKE_GENERATOR:-Ninja}
  export CMAKE_GENERATOR
  { install_step $viewer_packages && install_step $vtk_packages; } || echo "== going on without the viewer" >&2
  install_step $multibody_packages || echo "== going on without Simbody" >&2
  install_step $python_packages || echo "== going on without the Python module" >&2
  install_step $fmi_packages || echo "== going on without units of FMI" >&2
  install_step $sound_packages || echo "== going on without sound" >&2
  install_step $driver_packages || echo "== going on without the driver haply" >&2
  install_step $page_packages || echo "== going on without enamel replay --html and figures of reports" >&2
  install_step $person_packages || echo "== going on without the tests of a person at the window" >&2
}
