"""What Dockerfile, compose files and provisioning in docker/ say of each other and of the server, without a container engine."""

import json
import pathlib
import re
import sys
import unittest

import yaml

ROOT = pathlib.Path(__file__).resolve().parents[2]
DOCKER = ROOT / "docker"


def read(path):
    return (ROOT / path).read_text(encoding="utf-8")


def parsed(name):
    return yaml.safe_load((DOCKER / name).read_text(encoding="utf-8"))


DOCKERFILE = read("docker/Dockerfile").replace("\\\n", "")
COMPOSE, PAIR = parsed("compose.yaml"), parsed("compose.postgres.yaml")


def stage(name):
    return re.search(rf"^FROM \S+ AS {name}\n(.*?)(?=^FROM |\Z)", DOCKERFILE, re.M | re.S).group(1)


def services():
    for file in (COMPOSE, PAIR):
        yield from file["services"].items()


def mounts(service):
    return [entry.split(":") for entry in service.get("volumes", [])]


class Image(unittest.TestCase):
    def test_stages_and_what_they_copy(self):
        self.assertEqual(re.findall(r"^FROM \S+ AS (\w+)$", DOCKERFILE, re.M), ["build", "server", "robot", "test"])
        for source in re.findall(r"^COPY (?!--)(\S+) ", DOCKERFILE, re.M):
            self.assertTrue((ROOT / source).exists(), source)
        made = set(re.findall(r"^package (\S+) ", read("docker/package"), re.M))
        self.assertEqual(set(re.findall(r"packages/([a-z0-9-]+)_\*\.deb", DOCKERFILE)), made - {"libheadframe-dev"})
        self.assertIn("libheadframe-dev", made)  # for who links the library: no image runs a compiler
        for command in re.findall(r"\./run (\w+)", DOCKERFILE):
            self.assertRegex(read("run"), rf"\n  {command}\)\s")

    def test_ports_and_paths_are_the_servers(self):
        main, unit = read("server/main.cpp"), read("docker/packages/headframe-server.service")
        ports = [re.search(rf'{name} = "127.0.0.1:(\d+)"', main).group(1) for name in ("listen", "http")]
        server = stage("server")
        self.assertEqual(re.search(r"^EXPOSE (.*)$", server, re.M).group(1).split(), ports)
        command = json.loads(re.search(r"^CMD (.*)$", server, re.M).group(1))
        self.assertEqual(command, ["--listen", f"0.0.0.0:{ports[0]}", "--http", f"0.0.0.0:{ports[1]}"])
        entry = json.loads(re.search(r"^ENTRYPOINT (.*)$", server, re.M).group(1))
        self.assertIn(" ".join(entry), unit)
        data = entry[entry.index("--data") + 1]
        self.assertIn(f"VOLUME {data}\n", server)
        self.assertIn(f"HEADFRAME_TOKEN_FILE={data}/operator.token", server)
        self.assertIn(f"https://127.0.0.1:{ports[1]} ", server)
        self.assertIn('envname("HEADFRAME_HTTP")', read("server/cli/main.cpp"))
        check = re.search(r"^HEALTHCHECK .*CMD (.*)$", server, re.M).group(1)
        self.assertIn(f"/dev/tcp/127.0.0.1/{ports[1]} ", json.loads(check)[2])
        for name, service in services():
            if name in ("server", "standby"):
                self.assertEqual([p.split(":")[-1] for p in service.get("ports", [])] or ports, ports, name)
                self.assertIn(entry[-1], [m[1] for m in mounts(service)], name)


class Compose(unittest.TestCase):
    def test_what_is_named_is_there(self):
        volumes = set(COMPOSE["volumes"]) | set(PAIR["volumes"])
        names = dict(services())
        for name, service in services():
            for source, *_ in mounts(service):
                self.assertTrue((DOCKER / source).exists() if source[0] == "." else source in volumes, (name, source))
            self.assertLessEqual(set(service.get("depends_on", [])), set(names), name)
            if "build" in service:
                self.assertTrue((DOCKER / service["build"]["context"] / service["build"]["dockerfile"]).exists())
                self.assertTrue(stage(service["build"]["target"]))

    def test_settings_are_known(self):
        known = re.findall(r'\{"(\w+)", "(\w+)", &', read("server/config/server_config.cpp"))
        section = ""
        for line in read("docker/postgres/headframe.toml").splitlines():
            section = (re.findall(r"^\[(\w+)\]", line) or [section])[0]
            for key in re.findall(r"^(\w+) = ", line):
                self.assertIn((section, key), known)

    def test_prometheus_and_grafana_find_their_way(self):
        prometheus, grafana = COMPOSE["services"]["prometheus"], COMPOSE["services"]["grafana"]
        settings = parsed("prometheus/prometheus.yml")
        for rules in settings["rule_files"]:
            self.assertTrue(parsed("prometheus/" + rules)["groups"])
        (job,) = settings["scrape_configs"]
        self.assertRegex(job["job_name"], "headframe")  # the rules look for that
        host, port = job["static_configs"][0]["targets"][0].split(":")
        for service in (COMPOSE["services"]["server"], PAIR["services"]["standby"]):
            self.assertIn(host, service["networks"]["default"]["aliases"])
            self.assertEqual(service["ports"][1].split(":")[-1], port)
        token = job["authorization"]["credentials_file"].rpartition("/")
        self.assertIn(["scrape-token", token[0], "ro"], mounts(prometheus))
        self.assertIn(["scrape-token", token[0]], mounts(COMPOSE["services"]["scrape-token"]))
        self.assertIn(f"mv next {token[2]}", COMPOSE["services"]["scrape-token"]["command"][0])
        (source,) = parsed("grafana/provisioning/datasources/prometheus.yml")["datasources"]
        self.assertEqual(source["url"], "http://prometheus:" + prometheus["ports"][0].split(":")[-1])
        (provider,) = parsed("grafana/provisioning/dashboards/headframe.yml")["providers"]
        boards = [m for m in mounts(grafana) if pathlib.PurePath(m[1]).parent == pathlib.PurePath(provider["options"]["path"])]
        self.assertEqual([json.loads((DOCKER / m[0]).read_text())["title"] for m in boards], ["headframe"])


if __name__ == "__main__":
    sys.dont_write_bytecode = True
    unittest.main()
