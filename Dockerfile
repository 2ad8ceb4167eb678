# An image with `hypertexture` and Mesa's lavapipe, which needs no GPU:
#   docker build -t hypertexture . && docker run --rm -v "$PWD:/pictures" hypertexture render teapot --effect fur -o fur.png

FROM debian:trixie-slim AS build
WORKDIR /source
# What setup.sh installs changes rarely: a layer of its own.
COPY setup.sh Cargo.toml ./
RUN ./setup.sh
COPY . .
# Without the window.
RUN cargo build --release --locked --no-default-features --features cli

FROM debian:trixie-slim
RUN apt-get update -q \
    && apt-get install -yq --no-install-recommends libshaderc1 libvulkan1 mesa-vulkan-drivers \
    && rm -rf /var/lib/apt/lists/* \
    && mkdir -m 1777 /pictures /var/cache/hypertexture
COPY --from=build /source/target/release/hypertexture /usr/local/bin/
ENV HYPERTEXTURE_CACHE=/var/cache/hypertexture
WORKDIR /pictures
ENTRYPOINT ["hypertexture"]
CMD ["--help"]
