# An image with `hypertexture` and Mesa's drivers; lavapipe needs no GPU:
#   docker build -t hypertexture . && docker run --rm -v "$PWD:/pictures" --user "$(id -u)" hypertexture render teapot --effect fur -o fur.png
# With an Intel or AMD GPU: --device /dev/dri --group-add "$(stat -c %g /dev/dri/renderD128)". With one of NVIDIA, and its
# container toolkit: --gpus all --env NVIDIA_DRIVER_CAPABILITIES=graphics,utility.

FROM debian:trixie-slim AS build
WORKDIR /source
# What setup.sh installs changes rarely: a layer of its own.
COPY setup.sh Cargo.toml ./
RUN ./setup.sh
RUN cargo install cargo-deb --locked
COPY . .
RUN release/build

FROM debian:trixie-slim
COPY --from=build /source/target/dist/package/hypertexture_*.deb /tmp/
RUN apt-get update -q \
    && apt-get install -yq --no-install-recommends /tmp/hypertexture_*.deb mesa-vulkan-drivers \
    && rm -rf /var/lib/apt/lists/* /tmp/hypertexture_*.deb \
    && useradd --uid 1000 --create-home hypertexture \
    && mkdir -m 1777 /pictures /var/cache/hypertexture
ENV HYPERTEXTURE_CACHE=/var/cache/hypertexture
USER hypertexture
WORKDIR /pictures
ENTRYPOINT ["hypertexture"]
CMD ["--help"]
